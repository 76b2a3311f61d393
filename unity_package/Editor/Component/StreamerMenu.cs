using UnityEditor;
using UnityEngine;

namespace Ml2Sensors.Editor
{
    /// <summary>Menu items that create a streamer with the project's settings, in the scene or as a prefab.</summary>
    internal static class StreamerMenu
    {
        [MenuItem("GameObject/ML2 Sensors/Sensor Streamer", false, 10)]
        public static void InScene()
        {
            GameObject streamer = Make();
            Undo.RegisterCreatedObjectUndo(streamer, "Create Sensor Streamer");
            Selection.activeObject = streamer;
        }

        [MenuItem("Assets/Create/ML2 Sensors/Sensor Streamer Prefab")]
        public static void AsPrefab()
        {
            GameObject streamer = Make();
            string path = AssetDatabase.GenerateUniqueAssetPath("Assets/ML2 Sensor Streamer.prefab");
            Selection.activeObject = PrefabUtility.SaveAsPrefabAsset(streamer, path);
            Object.DestroyImmediate(streamer);
        }

        private static GameObject Make()
        {
            var streamer = new GameObject("ML2 Sensor Streamer").AddComponent<Ml2SensorStreamer>();
            streamer.Receiver = Ml2SensorSettings.instance.Receiver;
            streamer.Config = Ml2SensorSettings.instance.Config;
            return streamer.gameObject;
        }
    }
}
