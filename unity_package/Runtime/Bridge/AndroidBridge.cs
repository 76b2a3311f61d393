using System;
using UnityEngine;
using UnityEngine.Scripting;

namespace Ml2Sensors.Bridge
{
    /// <summary>Calls dev.ml2sensors.unity.Ml2Unity in the bundled AAR, which loads libml2sensors when it is opened.</summary>
    internal sealed class AndroidBridge : IMl2Bridge
    {
        private readonly AndroidJavaObject _facade, _inboxes, _publishers, _services;

        /// <param name="changed">Called with each new status, on any thread.</param>
        public AndroidBridge(Action<string> changed)
        {
            using (var player = new AndroidJavaClass("com.unity3d.player.UnityPlayer"))
            using (var activity = player.GetStatic<AndroidJavaObject>("currentActivity"))
            using (var facade = new AndroidJavaClass("dev.ml2sensors.unity.Ml2Unity"))
                _facade = facade.CallStatic<AndroidJavaObject>("open", activity, new Listener(changed));
            _inboxes = _facade.Call<AndroidJavaObject>("inboxes");
            _publishers = _facade.Call<AndroidJavaObject>("publishers");
            _services = _facade.Call<AndroidJavaObject>("services");
        }

        public string Unavailable => null;

        public void Pair(string uri) => _facade.Call("pair", uri);

        public void Start(string receiver, string defaultsJson, bool insecure) =>
            _facade.Call("start", receiver, defaultsJson, insecure);

        public void Stop() => _facade.Call("stop");

        public void Pause() => _facade.Call("pause");

        public void Resume() => _facade.Call("resume");

        public string Status() => _facade.Call<string>("status");

        public string PermissionsNeeded() => _facade.Call<string>("permissionsNeeded");

        public void View(string streamId, bool on) => _facade.Call("view", streamId, on);

        public uint OpenPublisher(string topic, string rosType, bool isLatched, bool isLarge, bool isStamped, int depth) =>
            (uint)_publishers.Call<int>("open", topic, rosType, isLatched, isLarge, isStamped, depth);

        public string PublisherRefusal(uint outbox) => _publishers.Call<string>("refusal", (int)outbox);

        public uint CallService(string service, string rosType) => (uint)_services.Call<int>("call", service, rosType);

        public uint OfferService(string service, string rosType) => (uint)_services.Call<int>("offer", service, rosType);

        public uint ServiceInbox(uint service) => (uint)_services.Call<int>("inbox", (int)service);

        public string ServiceRefusal(uint service) => _services.Call<string>("refusal", (int)service);

        public void CloseService(uint service) => _services.Call("close", (int)service);

        public uint Subscribe(string topic, string rosType, string hash, int depth, double maxHz) =>
            (uint)_inboxes.Call<int>("subscribe", topic, rosType, hash, depth, maxHz);

        public void Unsubscribe(uint inbox) => _inboxes.Call("unsubscribe", (int)inbox);

        public string SubscriptionRefusal(uint inbox) => _inboxes.Call<string>("refusal", (int)inbox);

        public void Dispose()
        {
            _facade.Call("close");
            _inboxes.Dispose();
            _publishers.Dispose();
            _services.Dispose();
            _facade.Dispose();
        }

        private sealed class Listener : AndroidJavaProxy
        {
            private readonly Action<string> _changed;

            public Listener(Action<string> changed) : base("dev.ml2sensors.unity.Ml2UnityListener") => _changed = changed;

            /// <summary>Called by Java, which finds it by this name.</summary>
            [Preserve]
            public void changed(string statusJson) => _changed(statusJson);
        }
    }
}
