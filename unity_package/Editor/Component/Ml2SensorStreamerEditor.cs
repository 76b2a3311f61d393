using System.Linq;
using UnityEditor;
using UnityEngine;

namespace Ml2Sensors.Editor
{
    /// <summary>The inspector of a streamer: its fields, and in play mode the status of the library.</summary>
    [CustomEditor(typeof(Ml2SensorStreamer))]
    internal sealed class Ml2SensorStreamerEditor : UnityEditor.Editor
    {
        public override bool RequiresConstantRepaint() => Application.isPlaying;

        public override void OnInspectorGUI()
        {
            DrawDefaultInspector();
            var streamer = (Ml2SensorStreamer)target;
            if (streamer.Insecure) EditorGUILayout.HelpBox(Ml2SensorStreamer.InsecureWarning, MessageType.Warning);
            if (!Application.isPlaying) return;
            if (streamer.Unavailable != null) EditorGUILayout.HelpBox(streamer.Unavailable, MessageType.Info);
            else DrawStatus(streamer.Status);
        }

        private static void DrawStatus(Status status)
        {
            EditorGUILayout.LabelField("State", $"{status.State} {status.Receiver}");
            if (status.Reason != "") EditorGUILayout.HelpBox(status.Reason, MessageType.Info);
            string paired = string.Join(", ", status.Pairing.Receivers.Select(receiver => receiver.Name));
            EditorGUILayout.LabelField("Paired with", paired == "" ? "no receiver" : paired);
            foreach (var stream in status.Streams)
                EditorGUILayout.LabelField(stream.Key, $"{stream.Value.State} {stream.Value.Reason}");
            foreach (var channel in status.Channels)
            {
                string dropped = "";
                foreach (var reason in channel.Value.Dropped) dropped += $", {reason.Value} {reason.Key}";
                EditorGUILayout.LabelField(channel.Key, $"{channel.Value.Sent} of {channel.Value.Produced} sent{dropped}");
            }
            if (status.Clock != null)
                EditorGUILayout.LabelField("Clock", $"{status.Clock.State}, ±{status.Clock.UncertaintyNanos / 1e6:0.000} ms");
        }
    }
}
