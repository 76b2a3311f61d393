using System;
using Object = UnityEngine.Object;

namespace UnityEditor
{
    public enum MessageType
    {
        Info,
        Warning,
        Error,
    }

    public static class EditorStyles
    {
        public static readonly UnityEngine.GUIStyle boldLabel = new UnityEngine.GUIStyle();
    }

    public static class EditorGUI
    {
        public static void BeginChangeCheck()
        {
        }

        public static bool EndChangeCheck() => false;
    }

    public static class EditorGUILayout
    {
        public static void LabelField(string label, UnityEngine.GUIStyle style)
        {
        }

        public static void LabelField(string label, string text)
        {
        }

        public static void HelpBox(string message, MessageType type)
        {
        }

        public static string TextField(string label, string text) => text;

        public static Object ObjectField(string label, Object value, Type type, bool allowSceneObjects) => value;
    }
}
