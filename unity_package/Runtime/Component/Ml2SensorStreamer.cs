using System;
using System.Collections.Generic;
using System.Threading;
using Ml2Sensors.Bridge;
using UnityEngine;

namespace Ml2Sensors
{
    /// <summary>
    /// Streams the headset's sensors to ROS 2. Capture and sending are the native library's and run on its own threads;
    /// this component starts and stops them and raises their news as events, on Unity's main thread. Its Update
    /// allocates nothing while there is no news. One per app.
    /// </summary>
    [AddComponentMenu("ML2 Sensors/ML2 Sensor Streamer")]
    [DisallowMultipleComponent]
    public sealed class Ml2SensorStreamer : MonoBehaviour
    {
        internal const string InsecureWarning =
            "Insecure: nothing is encrypted, and anybody on the network can read along and pretend to be the receiver.";

        [Tooltip("Empty: the one that the headset is paired with. Or a receiver's name, or host:port; paired, too.")]
        [SerializeField] private string _receiver = "";

        [Tooltip("Encrypt nothing and trust every receiver, which has to run with --insecure. Eye images are refused.")]
        [SerializeField] private bool _insecure;

        [Tooltip("Start when this component is enabled.")]
        [SerializeField] private bool _startAutomatically = true;

        [Tooltip("Show the system's dialog for permissions that streams lack.")]
        [SerializeField] private bool _askForPermissions = true;

        [Tooltip("What runs when the receiver does not say; none: nothing.")]
        [SerializeField] private Ml2SensorConfig _config;

        private readonly PermissionRequests _permissions = new PermissionRequests();
        private readonly Dictionary<StreamId, int> _views = new Dictionary<StreamId, int>();
        private string _news;
        private IMl2Bridge _bridge;
        private bool _isWanted;
        private bool _isStarted;

        /// <summary>With the receiver's name or address.</summary>
        public event Action<string> Connected;

        /// <summary>With the reason.</summary>
        public event Action<string> Disconnected;

        /// <summary>With the receiver. A stream that is not insecure starts anew by itself.</summary>
        public event Action<PairedReceiver> Paired;

        /// <summary>With the reason.</summary>
        public event Action<string> PairingFailed;

        /// <summary>The receiver's configuration took effect; Status.Streams has the values.</summary>
        public event Action<Status> ConfigurationApplied;

        /// <summary>With stream id and reason; also for a stream that ran and failed.</summary>
        public event Action<string, string> StreamRefused;

        /// <summary>Raised before the system's dialog, so that the reason can be shown.</summary>
        public event Action<PermissionNeed> PermissionNeeded;

        /// <summary>Of the last Update. Replaced, never changed.</summary>
        public Status Status { get; private set; } = Status.Initial;

        /// <summary>See the field; takes effect with the next start.</summary>
        public string Receiver
        {
            get => _receiver;
            set => _receiver = value ?? "";
        }

        /// <summary>See the field; takes effect with the next start.</summary>
        public bool Insecure
        {
            get => _insecure;
            set => _insecure = value;
        }

        /// <summary>See the field; takes effect with the next start.</summary>
        public Ml2SensorConfig Config
        {
            get => _config;
            set => _config = value;
        }

        /// <summary>Why nothing can stream on this platform; null where it can.</summary>
        public string Unavailable => Bridge.Unavailable;

        internal Func<Action<string>, IMl2Bridge> OpenBridge { get; set; } = Bridges.Open;

        internal IMl2Bridge Bridge => _bridge ?? (_bridge = OpenBridge(json => Interlocked.Exchange(ref _news, json)));

        /// <summary>
        /// Pairs with a receiver, needed once for each: Paired or PairingFailed tell what became of it, within seconds.
        /// Without effect while another pairing is under way.
        /// </summary>
        /// <param name="uri">What `ml2-receiver pair` shows, ml2s://..., as text or as a QR code; spaces around it aside.</param>
        public void Pair(string uri)
        {
            if (Unavailable != null) Debug.LogWarning(Unavailable, this);
            Bridge.Pair(uri ?? "");
        }

        /// <summary>Begins as soon as the user has answered for permissions; without effect when begun.</summary>
        public void StartStreaming()
        {
            if (_isWanted) return;
            _isWanted = true;
            if (Unavailable != null) Debug.LogWarning(Unavailable, this);
            else if (_insecure) Debug.LogWarning(InsecureWarning, this);
            AskForPermissions();
            ContinueStart();
        }

        /// <summary>Ends the session; without effect when none was begun.</summary>
        public void StopStreaming()
        {
            _isWanted = false;
            if (!_isStarted) return;
            _isStarted = false;
            Bridge.Stop();
        }

        /// <summary>Views are counted: the last to go ends them.</summary>
        internal void AddView(StreamId stream)
        {
            _views.TryGetValue(stream, out int count);
            _views[stream] = count + 1;
            if (count == 0) Bridge.View(StreamTable.Rows[(int)stream].Id, true);
        }

        internal void RemoveView(StreamId stream)
        {
            int left = --_views[stream];
            if (left == 0 && _bridge != null) _bridge.View(StreamTable.Rows[(int)stream].Id, false);
        }

        private void OnEnable()
        {
            if (_startAutomatically) StartStreaming();
        }

        private void Update()
        {
            string news = Interlocked.Exchange(ref _news, null);
            if (news != null) Take(StatusReader.ReadStatus(news));
            if (!_permissions.IsWaiting) ContinueStart();
        }

        private void OnApplicationPause(bool isPaused)
        {
            if (!_isStarted) return;
            if (isPaused) Bridge.Pause();
            else Bridge.Resume();
        }

        private void OnDisable() => StopStreaming();

        private void OnDestroy()
        {
            _bridge?.Dispose();
            _bridge = null;
        }

        /// <summary>A permission that came later needs another start: what was refused is refused for a session.</summary>
        private void ContinueStart()
        {
            if (_permissions.IsWaiting) return;
            bool hasNewPermission = _permissions.TakeGranted();
            if (!_isWanted || (_isStarted && !hasNewPermission)) return;
            _isStarted = true;
            Bridge.Start(_receiver, _config == null ? "{}" : _config.ToJson(), _insecure);
        }

        private void Take(Status now)
        {
            Status before = Status;
            Status = now;
            if (StatusChanges.HasPaired(before, now)) Paired?.Invoke(now.Pairing.Receivers[now.Pairing.Receivers.Count - 1]);
            if (StatusChanges.HasFailedToPair(before, now)) PairingFailed?.Invoke(now.Pairing.Reason);
            if (StatusChanges.HasDisconnected(before, now)) Disconnected?.Invoke(now.Reason);
            if (StatusChanges.HasConnected(before, now)) Connected?.Invoke(now.Receiver);
            if (StatusChanges.HasNewConfiguration(before, now)) ConfigurationApplied?.Invoke(now);
            bool isRefused = false;
            foreach (var stream in StatusChanges.Refused(before, now))
            {
                isRefused = true;
                StreamRefused?.Invoke(stream.Key, stream.Value.Reason);
            }
            if (isRefused) AskForPermissions();
        }

        private void AskForPermissions()
        {
            var needs = _permissions.TakeNew(StatusReader.ReadPermissions(Bridge.PermissionsNeeded()));
            foreach (PermissionNeed need in needs) PermissionNeeded?.Invoke(need);
            if (_askForPermissions) _permissions.Ask(needs);
        }
    }
}
