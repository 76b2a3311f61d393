using System;
using System.Collections.Generic;
using System.Threading;
using Ml2Sensors.Bridge;
using UnityEngine;

namespace Ml2Sensors
{
    /// <summary>
    /// Streams the headset's sensors to ROS 2. The native library captures and sends on its own threads. This component
    /// starts and stops it, and raises events on Unity's main thread. Update allocates nothing while the status does not
    /// change. Use one per app.
    /// </summary>
    [AddComponentMenu("ML2 Sensors/ML2 Sensor Streamer")]
    [DisallowMultipleComponent]
    public sealed class Ml2SensorStreamer : MonoBehaviour
    {
        internal const string InsecureWarning =
            "Insecure: nothing is encrypted. Anyone on the network can read the data and pose as the receiver.";

        [Tooltip("The name or host:port of a paired receiver. Empty: the paired receiver, found on the network.")]
        [SerializeField] private string _receiver = "";

        [Tooltip("Do not encrypt, and trust every receiver that runs with --insecure. Eye images are refused.")]
        [SerializeField] private bool _insecure;

        [Tooltip("Start streaming when this component is enabled.")]
        [SerializeField] private bool _startAutomatically = true;

        [Tooltip("Request the permissions that streams lack, by the system's dialog.")]
        [SerializeField] private bool _askForPermissions = true;

        [Tooltip("The streams that run if the receiver does not choose. None: no streams.")]
        [SerializeField] private Ml2SensorConfig _config;

        private readonly PermissionRequests _permissions = new PermissionRequests();
        private readonly Dictionary<StreamId, int> _views = new Dictionary<StreamId, int>();
        private string _newStatusJson;
        private IMl2Bridge _bridge;
        private bool _isRequested;
        private bool _isStarted;

        /// <summary>The latest state of the platform, and the state that the library was told.</summary>
        private bool _isPaused, _isLibraryPaused;

        /// <summary>Raised when a session begins, with the receiver's name or address.</summary>
        public event Action<string> Connected;

        /// <summary>Raised when a session ends, with the reason.</summary>
        public event Action<string> Disconnected;

        /// <summary>Raised after a pairing, with the receiver. Streaming then restarts by itself, unless it is insecure.</summary>
        public event Action<PairedReceiver> Paired;

        /// <summary>Raised after a failed pairing, with the reason.</summary>
        public event Action<string> PairingFailed;

        /// <summary>Raised when the receiver's configuration takes effect. Status.Streams holds the values.</summary>
        public event Action<Status> ConfigurationApplied;

        /// <summary>Raised with stream id and reason when a stream is refused, waits or fails.</summary>
        public event Action<string, string> StreamRefused;

        /// <summary>Raised before the system's dialog, so that the app can show the reason.</summary>
        public event Action<PermissionNeed> PermissionNeeded;

        /// <summary>The status at the last Update. The object is immutable and is replaced by a new one.</summary>
        public Status Status { get; private set; } = Status.Initial;

        /// <summary>The name or host:port of a paired receiver; empty for the paired one. Takes effect at the next start.</summary>
        public string Receiver
        {
            get => _receiver;
            set => _receiver = value ?? "";
        }

        /// <summary>True turns off encryption and trusts every receiver. Takes effect at the next start.</summary>
        public bool Insecure
        {
            get => _insecure;
            set => _insecure = value;
        }

        /// <summary>The streams that run if the receiver does not choose. Takes effect at the next start.</summary>
        public Ml2SensorConfig Config
        {
            get => _config;
            set => _config = value;
        }

        /// <summary>The reason why this component cannot stream here, or any more; null if it can.</summary>
        public string Unavailable => Bridge.Unavailable;

        internal Func<Action<string>, IMl2Bridge> OpenBridge { get; set; } = OpenPlatformBridge;

        internal Pump Pump { get; } = new Pump();

        internal IMl2Bridge Bridge => _bridge ?? (_bridge = OpenBridge(json => Interlocked.Exchange(ref _newStatusJson, json)));

        /// <summary>
        /// Pairs with a receiver, which is needed once for each. Raises Paired or PairingFailed within seconds. Has no effect
        /// while another pairing runs.
        /// </summary>
        /// <param name="uri">The URI ml2s://... from `ml2-receiver pair`. Spaces around it are ignored.</param>
        public void Pair(string uri)
        {
            if (Unavailable != null) Debug.LogWarning(Unavailable, this);
            Bridge.Pair(uri ?? "");
        }

        /// <summary>Starts to stream once the user has answered all permission requests. Has no effect if already started.</summary>
        public void StartStreaming()
        {
            if (_isRequested) return;
            _isRequested = true;
            if (Unavailable != null) Debug.LogWarning(Unavailable, this);
            else if (_insecure) Debug.LogWarning(InsecureWarning, this);
            _permissions.ForgetCancelled();
            AskForPermissions();
            ContinueStart();
        }

        /// <summary>Stops streaming. Has no effect if it was not started.</summary>
        public void StopStreaming()
        {
            _isRequested = false;
            if (!_isStarted) return;
            _isStarted = false;
            Bridge.Stop();
        }

        /// <summary>Adds a reader of a stream's frames. Readers are counted; removing the last one ends the access.</summary>
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

        private static IMl2Bridge OpenPlatformBridge(Action<string> changed)
        {
            if (Application.platform == RuntimePlatform.Android) return new AndroidBridge(changed);
            return new UnavailableBridge(
                $"ML2 Sensors streams on the headset only; on {Application.platform} nothing is captured or sent.");
        }

        private void OnEnable()
        {
            if (_startAutomatically) StartStreaming();
        }

        private void Update()
        {
            string json = Interlocked.Exchange(ref _newStatusJson, null);
            if (json != null) Apply(StatusReader.ReadStatus(json));
            if (!_permissions.IsWaiting) ContinueStart();
            Pump.Run();
        }

        private void OnApplicationPause(bool isPaused)
        {
            _isPaused = isPaused;
            PauseLibrary();
            if (!isPaused) LookAtPermissions();
        }

        private void OnApplicationFocus(bool hasFocus)
        {
            if (hasFocus) LookAtPermissions();
        }

        private void OnDisable()
        {
            StopStreaming();
            // Unity does not tell an inactive object that the app is resumed
            _isPaused = false;
        }

        private void OnDestroy()
        {
            _bridge?.Dispose();
            // Scripts may outlive this component, and nobody would close a library that they opened
            _bridge = new UnavailableBridge("This ML2 Sensor Streamer is destroyed.");
            _isLibraryPaused = false;
            Pump.End();
        }

        /// <summary>Tells a started library whether the app is paused, if it does not know.</summary>
        private void PauseLibrary()
        {
            if (!_isStarted || _isLibraryPaused == _isPaused) return;
            _isLibraryPaused = _isPaused;
            if (_isPaused) Bridge.Pause();
            else Bridge.Resume();
        }

        /// <summary>Finds permissions that were granted anywhere, and requests that Android ended without an answer.</summary>
        private void LookAtPermissions()
        {
            if (_bridge != null) _permissions.Look(Needs(), true);
        }

        private IReadOnlyList<PermissionNeed> Needs() => StatusReader.ReadPermissions(Bridge.PermissionsNeeded());

        /// <summary>Starts, or restarts after a new permission, since a refused stream stays refused for the session.</summary>
        private void ContinueStart()
        {
            if (_permissions.IsWaiting) return;
            bool hasNewPermission = _permissions.TakeGranted();
            if (!_isRequested || (_isStarted && !hasNewPermission)) return;
            _isStarted = true;
            Bridge.Start(_receiver, _config == null ? "{}" : _config.ToJson(), _insecure);
            PauseLibrary();
        }

        private void Apply(Status now)
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
            var missing = Needs();
            _permissions.Look(missing, false);
            var needs = _permissions.TakeNew(missing);
            foreach (PermissionNeed need in needs) PermissionNeeded?.Invoke(need);
            if (_askForPermissions) _permissions.Ask(needs);
        }
    }
}
