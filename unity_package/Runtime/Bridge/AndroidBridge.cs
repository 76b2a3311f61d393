using System;
using UnityEngine;
using UnityEngine.Scripting;

namespace Ml2Sensors.Bridge
{
    /// <summary>Calls dev.ml2sensors.unity.Ml2Unity in the bundled AAR, which loads libml2sensors when it is opened.</summary>
    internal sealed class AndroidBridge : IMl2Bridge
    {
        private readonly AndroidJavaObject _facade;

        /// <param name="changed">Called with each new status, on any thread.</param>
        public AndroidBridge(Action<string> changed)
        {
            using (var player = new AndroidJavaClass("com.unity3d.player.UnityPlayer"))
            using (var activity = player.GetStatic<AndroidJavaObject>("currentActivity"))
            using (var facade = new AndroidJavaClass("dev.ml2sensors.unity.Ml2Unity"))
                _facade = facade.CallStatic<AndroidJavaObject>("open", activity, new Listener(changed));
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

        public int OpenPublisher(string topic, string rosType) => _facade.Call<int>("openPublisher", topic, rosType);

        public long StampNanos(long captureNanos) => _facade.Call<long>("stampNanos", captureNanos);

        public string Refusal(int publisher) => _facade.Call<string>("refusal", publisher);

        public bool Publish(int publisher, byte[] payload, int length, long captureNanos)
        {
            var bytes = new sbyte[length]; // Java's byte
            Buffer.BlockCopy(payload, 0, bytes, 0, length);
            return _facade.Call<bool>("publish", publisher, bytes, captureNanos);
        }

        public void Dispose()
        {
            _facade.Call("close");
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
