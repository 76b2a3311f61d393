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

        /// <summary>The status says what becomes of it; without effect while another is under way.</summary>
        /// <param name="uri">As ml2-receiver pair shows it.</param>
        void Pair(string uri);

        /// <param name="receiver">"" for the paired one, a receiver's name, or "host:port".</param>
        /// <param name="defaultsJson">Streams that run when no receiver says otherwise, as CONFIGURE's; "{}" for none.</param>
        /// <param name="insecure">Encrypts nothing and trusts every receiver; "" is the only one there is then.</param>
        void Start(string receiver, string defaultsJson, bool insecure);

        void Stop();

        void Pause();

        void Resume();

        string Status();

        /// <summary>A list of {permission, reason, streams}.</summary>
        string PermissionsNeeded();

        /// <summary>Whether the stream's frames are to be had through FrameLease.</summary>
        void View(string streamId, bool on);

        /// <param name="topic">Relative to the prefix: "custom/" and a name.</param>
        /// <returns>What Publish takes.</returns>
        int OpenPublisher(string topic, string rosType);

        /// <summary>ROS time of an instant of CLOCK_BOOTTIME; 0 while it is not known.</summary>
        long StampNanos(long captureNanos);

        /// <summary>Why the receiver does not publish the topic; empty as long as it does.</summary>
        string Refusal(int publisher);

        /// <param name="captureNanos">CLOCK_BOOTTIME.</param>
        /// <returns>False while no receiver takes it.</returns>
        bool Publish(int publisher, byte[] payload, int length, long captureNanos);
    }
}
