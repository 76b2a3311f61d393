namespace UnityEngine
{
    public class GUIStyle
    {
    }

    public class GUILayoutOption
    {
    }

    public static class GUILayout
    {
        public static bool Button(string text, params GUILayoutOption[] options) => false;

        public static void Label(string text, params GUILayoutOption[] options)
        {
        }
    }
}
