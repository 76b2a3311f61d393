namespace Ml2Sensors.Bridge
{
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

        public int OpenPublisher(string topic, string rosType) => 0;

        public long StampNanos(long captureNanos) => 0;

        public string Refusal(int publisher) => Unavailable;

        public bool Publish(int publisher, byte[] payload, int length, long captureNanos) => false;

        public void Dispose()
        {
        }
    }
}
