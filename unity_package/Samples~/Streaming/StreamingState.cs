using System.Collections.Generic;
using UnityEngine;

namespace Ml2Sensors.Samples
{
    /// <summary>Shows what the streamer says on a text of the scene.</summary>
    public sealed class StreamingState : MonoBehaviour
    {
        [SerializeField] private Ml2SensorStreamer _streamer;
        [SerializeField] private TextMesh _text;

        private readonly Dictionary<string, string> _refused = new Dictionary<string, string>();
        private string _state = "starting";

        private void OnEnable()
        {
            _streamer.Connected += ShowConnected;
            _streamer.Disconnected += ShowDisconnected;
            _streamer.StreamRefused += ShowRefused;
            _streamer.PermissionNeeded += ShowPermission;
            Show(_streamer.Unavailable ?? "looking for a receiver");
        }

        private void OnDisable()
        {
            _streamer.Connected -= ShowConnected;
            _streamer.Disconnected -= ShowDisconnected;
            _streamer.StreamRefused -= ShowRefused;
            _streamer.PermissionNeeded -= ShowPermission;
        }

        private void ShowConnected(string receiver)
        {
            _refused.Clear();
            Show($"connected to {receiver}");
        }

        private void ShowDisconnected(string reason) => Show($"not connected: {reason}");

        private void ShowPermission(PermissionNeed need) => Show($"please allow {need.Permission}: {need.Reason}");

        private void ShowRefused(string stream, string reason)
        {
            _refused[stream] = reason;
            Show(_state);
        }

        private void Show(string state)
        {
            _state = state;
            string text = state;
            foreach (var refused in _refused) text += $"\n{refused.Key}: {refused.Value}";
            _text.text = text;
        }
    }
}
