using System.Collections.Generic;
using System.Linq;
using UnityEditor;
using UnityEngine;

namespace Ml2Sensors.Editor
{
    /// <summary>The page Project Settings > ML2 Sensors.</summary>
    internal static class Ml2SensorSettingsPage
    {
        [SettingsProvider]
        public static SettingsProvider Create() => new SettingsProvider("Project/ML2 Sensors", SettingsScope.Project)
        {
            label = "ML2 Sensors",
            guiHandler = _ => Draw(),
            keywords = new HashSet<string> { "magic leap", "ros", "receiver", "streams", "permissions" },
        };

        private static void Draw()
        {
            DrawDefaults(Ml2SensorSettings.instance);
            EditorGUILayout.LabelField("Security", EditorStyles.boldLabel);
            EditorGUILayout.HelpBox(
                "Connections are encrypted, and only paired receivers are accepted, unless Insecure is set on a streamer. " +
                "The README describes pairing.", MessageType.Info);
            EditorGUILayout.LabelField("Build", EditorStyles.boldLabel);
            foreach (BuildCheck check in BuildCheck.All.Where(check => !check.IsGood))
            {
                EditorGUILayout.HelpBox(check.Problem, MessageType.Error);
                if (GUILayout.Button("Fix")) check.Fix();
            }
        }

        private static void DrawDefaults(Ml2SensorSettings settings)
        {
            EditorGUI.BeginChangeCheck();
            EditorGUILayout.LabelField("New streamers", EditorStyles.boldLabel);
            string receiver = EditorGUILayout.TextField("Receiver", settings.Receiver);
            var config = (Ml2SensorConfig)EditorGUILayout.ObjectField("Streams", settings.Config, typeof(Ml2SensorConfig), false);
            if (EditorGUI.EndChangeCheck()) settings.Set(receiver, config);
            string permissions = config == null
                ? "No streams are chosen, so the app declares no sensor permissions."
                : $"The app declares: {string.Join(", ", config.Permissions.DefaultIfEmpty("none"))}.";
            EditorGUILayout.HelpBox(permissions, MessageType.Info);
        }
    }
}
