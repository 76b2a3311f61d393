namespace Ml2Sensors.Bridge
{
    /// <summary>Where there is no headset: does nothing, and says so.</summary>
    internal sealed class NullBridge : IMl2Bridge
    {
        public NullBridge(string platform) =>
            Unavailable = $"ML2 Sensors streams on the headset only; on {platform} nothing is captured or sent.";

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
