using System;

namespace Ml2Sensors.Bridge
{
    /// <summary>
    /// Calls the Kotlin library, which captures and sends on its own threads. All calls come from Unity's main thread, and
    /// none is made per frame. Structured values are JSON.
    /// </summary>
    internal interface IMl2Bridge : IDisposable
    {
        /// <summary>The reason why this platform cannot stream; null if it can.</summary>
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

        /// <summary>Opens a topic of the app's own, over starts and stops.</summary>
        /// <param name="topic">"custom/" and a name, relative to the prefix; or an absolute name.</param>
        /// <param name="isStamped">True if messages begin with a header, whose stamp the library writes.</param>
        /// <param name="depth">The messages that wait to be sent; the newest ones stay.</param>
        /// <returns>The number of the outbox for NativeMethods.AddMessage; 0 where nothing is sent.</returns>
        uint OpenPublisher(string topic, string rosType, bool isLatched, bool isLarge, bool isStamped, int depth);

        /// <summary>Returns the reason why the receiver does not publish the topic; empty if it does.</summary>
        string PublisherRefusal(uint outbox);

        /// <summary>Opens a client of a service of ROS, over starts and stops.</summary>
        /// <returns>
        /// The number of the outbox for its requests: the number of a message is that of the call, its time the time-out in
        /// ns. Each call has one message in the inbox: a payload, or a byte of ServiceFailure and the reason in UTF-8. 0 where
        /// nothing is sent.
        /// </returns>
        uint CallService(string service, string rosType);

        /// <summary>Offers a service to ROS, over starts and stops.</summary>
        /// <returns>
        /// The number of the outbox for responses: a payload, or a byte of 1 and a reason in UTF-8, with the number that the
        /// request has in the inbox. 0 where nothing is received.
        /// </returns>
        uint OfferService(string service, string rosType);

        /// <summary>Returns the number of the inbox of a service.</summary>
        uint ServiceInbox(uint service);

        /// <summary>Returns the reason why ROS does not have a service that is offered; empty if it does.</summary>
        string ServiceRefusal(uint service);

        void CloseService(uint service);

        /// <summary>Subscribes to a ROS topic, over starts and stops.</summary>
        /// <param name="depth">The messages that wait for a frame; 1 is the newest alone.</param>
        /// <param name="maxHz">The greatest rate at which the receiver sends messages; 0 has no bound.</param>
        /// <returns>The number of the inbox for NativeMethods.AcquireMessage; 0 where nothing is received.</returns>
        uint Subscribe(string topic, string rosType, string hash, int depth, double maxHz);

        void Unsubscribe(uint inbox);

        /// <summary>Returns the reason why the receiver does not send the topic; empty if it does.</summary>
        string SubscriptionRefusal(uint inbox);
    }

    /// <summary>The bridge where there is no headset: does nothing, and says why.</summary>
    internal sealed class UnavailableBridge : IMl2Bridge
    {
        public UnavailableBridge(string reason) => Unavailable = reason;

        public string Unavailable { get; }

        public void Pair(string uri)
        {
        }

        public void Start(string receiver, string defaultsJson, bool insecure)
        {
        }

        public void Stop()
        {
        }

        public void Pause()
        {
        }

        public void Resume()
        {
        }

        public string Status() => "{\"state\": \"ended\"}";

        public string PermissionsNeeded() => "[]";

        public void View(string streamId, bool on)
        {
        }

        public uint OpenPublisher(string topic, string rosType, bool isLatched, bool isLarge, bool isStamped, int depth) => 0;

        public string PublisherRefusal(uint outbox) => Unavailable;

        public uint CallService(string service, string rosType) => 0;

        public uint OfferService(string service, string rosType) => 0;

        public uint ServiceInbox(uint service) => 0;

        public string ServiceRefusal(uint service) => Unavailable;

        public void CloseService(uint service)
        {
        }

        public uint Subscribe(string topic, string rosType, string hash, int depth, double maxHz) => 0;

        public void Unsubscribe(uint inbox)
        {
        }

        public string SubscriptionRefusal(uint inbox) => Unavailable;

        public void Dispose()
        {
        }
    }
}
