using System;
using System.Collections.Generic;
using System.Linq;
using Ml2Sensors.Bridge;

namespace Ml2Sensors.Tests
{
    /// <summary>Records its calls, and reports the status that a test sets.</summary>
    internal sealed class ScriptedBridge : IMl2Bridge
    {
        private readonly Action<string> _changed;

        public ScriptedBridge(Action<string> changed) => _changed = changed;

        public List<string> Calls { get; } = new List<string>();

        public string Needs { get; set; } = "[]";

        public byte[] LastPayload { get; private set; }

        public string Unavailable { get; set; }

        /// <summary>Raises a status on another thread, as the library does.</summary>
        public void RaiseStatus(string status)
        {
            var thread = new System.Threading.Thread(() => _changed(status.Replace('\'', '"')));
            thread.Start();
            thread.Join();
        }

        public void Pair(string uri) => Calls.Add($"pair {uri}");

        public void Start(string receiver, string defaultsJson, bool insecure) =>
            Calls.Add($"start \"{receiver}\" {defaultsJson}{(insecure ? " insecure" : "")}");

        public void Stop() => Calls.Add("stop");

        /// <summary>True between Pause and Resume.</summary>
        public bool IsPaused { get; private set; }

        public void Pause()
        {
            IsPaused = true;
            Calls.Add("pause");
        }

        public void Resume()
        {
            IsPaused = false;
            Calls.Add("resume");
        }

        public string Status() => "{\"state\": \"ended\"}";

        public string PermissionsNeeded() => Needs.Replace('\'', '"');

        public void View(string streamId, bool on) => Calls.Add($"view {streamId} {on}");

        public int OpenPublisher(string topic, string rosType)
        {
            Calls.Add($"open {topic} {rosType}");
            return 7;
        }

        /// <summary>ROS time minus CLOCK_BOOTTIME; null while it is not known.</summary>
        public long? OffsetNanos { get; set; }

        public long StampNanos(long captureNanos) => OffsetNanos == null ? 0 : captureNanos + OffsetNanos.Value;

        public string Refusal(int publisher) => "no such type";

        public bool Publish(int publisher, byte[] payload, int length, long captureNanos)
        {
            Calls.Add($"publish {publisher} {captureNanos}");
            LastPayload = payload.Take(length).ToArray();
            return true;
        }

        public void Dispose() => Calls.Add("close");
    }
}
