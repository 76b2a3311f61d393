using System;

namespace Ml2Sensors.Bridge
{
    /// <summary>
    /// The way to the Kotlin library, which captures and sends on threads of its own. Few calls, from Unity's main
    /// thread; none per frame. Structured values are JSON.
    /// </summary>
    internal interface IMl2Bridge : IDisposable
    {
        /// <summary>Why nothing can stream on this platform; null where it can.</summary>
        string Unavailable { get; }

        /// <param name="receiver">"" to discover one, its name, "host:port", or a pairing URI.</param>
        /// <param name="defaultsJson">Streams that run when no receiver says otherwise, as CONFIGURE's; "{}" for none.</param>
        void Start(string receiver, string defaultsJson);

        void Stop();

        void Pause();

        void Resume();

        string Status();

        /// <summary>A list of {permission, reason, streams}.</summary>
        string PermissionsNeeded();

        /// <summary>Whether the stream's frames are to be had through FrameLease.</summary>
        void View(string streamId, bool on);

        /// <param name="topic">Relative to the prefix: "custom/" and a name.</param>
        int OpenPublisher(string topic, string rosType);

        /// <param name="captureNanos">CLOCK_BOOTTIME.</param>
        /// <returns>False when it was dropped, which the library counts.</returns>
        bool Publish(int publisher, byte[] payload, int length, long captureNanos);
    }
}
