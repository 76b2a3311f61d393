using System;

namespace Ml2Sensors.Bridge
{
    /// <summary>
    /// Calls the Kotlin library, which captures and sends on its own threads. All calls come from Unity's main thread, and
    /// none is made per frame. Structured values are JSON.
    /// </summary>
    internal interface IMl2Bridge : IDisposable
    {
        /// <summary>Why this platform cannot stream; null if it can.</summary>
        string Unavailable { get; }

        /// <summary>Starts to pair; the status reports the result. Has no effect while another pairing runs.</summary>
        /// <param name="uri">The URI from ml2-receiver pair.</param>
        void Pair(string uri);

        /// <param name="receiver">A receiver's name or "host:port"; "" for the paired one.</param>
        /// <param name="defaultsJson">The streams that run if the receiver does not choose, in the format of CONFIGURE; "{}" for none.</param>
        /// <param name="insecure">True turns off encryption and trusts every receiver; then "" is the only receiver on the network.</param>
        void Start(string receiver, string defaultsJson, bool insecure);

        void Stop();

        void Pause();

        void Resume();

        string Status();

        /// <summary>Returns a list of {permission, reason, streams}.</summary>
        string PermissionsNeeded();

        /// <summary>Turns access to a stream's frames by FrameLease on or off.</summary>
        void View(string streamId, bool on);

        /// <param name="topic">"custom/" and a name, relative to the prefix.</param>
        /// <returns>The id that Publish takes.</returns>
        int OpenPublisher(string topic, string rosType);

        /// <summary>Converts a time of CLOCK_BOOTTIME to ROS time; 0 while ROS time is not known.</summary>
        long StampNanos(long captureNanos);

        /// <summary>Why the receiver does not publish the topic; empty if it does.</summary>
        string Refusal(int publisher);

        /// <param name="captureNanos">CLOCK_BOOTTIME.</param>
        /// <returns>False if no receiver takes the topic.</returns>
        bool Publish(int publisher, byte[] payload, int length, long captureNanos);
    }
}
