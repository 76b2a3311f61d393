using UnityEngine;

namespace Ml2Sensors.Samples
{
    /// <summary>Shows the status of the streamer as a text in the scene.</summary>
    public sealed class StreamingState : MonoBehaviour
    {
        [SerializeField] private Ml2SensorStreamer _streamer;
        [SerializeField] private TextMesh _text;

        private Status _shown;

        private void OnEnable()
        {
            // Names and reasons may come from others, and shall not be read as tags.
            _text.richText = false;
            _streamer.PermissionNeeded += ShowPermission;
        }

        private void OnDisable() => _streamer.PermissionNeeded -= ShowPermission;

        private void Update()
        {
            if (_streamer.Status == _shown) return;
            _shown = _streamer.Status;
            _text.text = _streamer.Unavailable ?? Describe(_shown);
        }

        private void ShowPermission(PermissionNeed need) =>
            _text.text = $"please allow {need.Permission}: {need.Reason}";

        private static string Describe(Status status)
        {
            string text = status.State == ConnectionState.Connected
                ? $"connected to {status.Receiver}"
                : $"not connected: {status.Reason}";
            if (status.IsInsecure) text += ", insecure";
            if (status.Pairing.State != PairingState.None) text += $"\npairing: {status.Pairing.State} {status.Pairing.Reason}";
            foreach (var stream in status.Streams)
                if (stream.Value.State != StreamState.Running) text += $"\n{stream.Key}: {stream.Value.Reason}";
            return text;
        }
    }
}
