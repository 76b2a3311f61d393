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

        /// <summary>The outboxes, in the order of their opening.</summary>
        public List<NativeInbox> Outboxes { get; } = new List<NativeInbox>();

        public uint OpenPublisher(string topic, string rosType, bool isLatched, bool isLarge, bool isStamped, int depth)
        {
            Calls.Add($"open {topic} {rosType}{(isLatched ? " latched" : "")}{(isLarge ? " large" : "")}{(isStamped ? " stamped" : "")} {depth}");
            Outboxes.Add(new NativeInbox(depth));
            return Outboxes.Last().Number;
        }

        public string PublisherRefusal(uint outbox) => "no such type";

        /// <summary>The outboxes of services, each with the inbox behind it, in the order of their opening.</summary>
        public List<NativeInbox> Services { get; } = new List<NativeInbox>();

        public uint CallService(string service, string rosType) => OpenService($"call {service} {rosType}");

        public uint OfferService(string service, string rosType) => OpenService($"offer {service} {rosType}");

        public uint ServiceInbox(uint service) => Services[Services.FindIndex(it => it.Number == service) + 1].Number;

        public string ServiceRefusal(uint service) => "no rule";

        public void CloseService(uint service)
        {
            Calls.Add("close service");
            int index = Services.FindIndex(it => it.Number == service);
            Services.GetRange(index, 2).ForEach(it => it.Dispose());
            Services.RemoveRange(index, 2);
        }

        private uint OpenService(string call)
        {
            Calls.Add(call);
            Services.Add(new NativeInbox(100));
            Services.Add(new NativeInbox(100));
            return Services[Services.Count - 2].Number;
        }

        /// <summary>The inboxes, in the order of the subscriptions.</summary>
        public List<NativeInbox> Inboxes { get; } = new List<NativeInbox>();

        public uint Subscribe(string topic, string rosType, string hash, int depth, double maxHz)
        {
            Calls.Add($"subscribe {topic} {rosType} {hash} {depth}{(maxHz == 0 ? "" : $" {maxHz} Hz")}");
            Inboxes.Add(new NativeInbox(depth));
            return Inboxes.Last().Number;
        }

        public void Unsubscribe(uint inbox)
        {
            Calls.Add("unsubscribe");
            Inboxes.Single(it => it.Number == inbox).Dispose();
        }

        public string SubscriptionRefusal(uint inbox) => "no such topic";

        public void Dispose()
        {
            Calls.Add("close");
            Outboxes.ForEach(it => it.Dispose());
            Services.ForEach(it => it.Dispose());
        }
    }
}
