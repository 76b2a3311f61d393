using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public enum RuntimePlatform
    {
        Android = 11,
        LinuxEditor = 16,
    }

    public static class Application
    {
        public static RuntimePlatform platform => RuntimePlatform.LinuxEditor;

        public static bool isPlaying => true;

        public static string absoluteURL => "";

        public static event Action<string> deepLinkActivated
        {
            add { }
            remove { }
        }
    }

    public static class Time
    {
        public static float time => 0;

        public static float realtimeSinceStartup { get; set; }
    }

    public static class Debug
    {
        public static readonly List<string> Warnings = new List<string>();

        public static readonly List<Exception> Exceptions = new List<Exception>();

        public static void Log(object message) { }

        public static void LogException(Exception exception) => Exceptions.Add(exception);

        public static void LogWarning(object message) => LogWarning(message, null);

        public static void LogWarning(object message, Object context) => Warnings.Add(message.ToString());
    }

    public class AndroidJavaObject : IDisposable
    {
        public void Call(string method, params object[] arguments) => throw new PlatformNotSupportedException();

        public T Call<T>(string method, params object[] arguments) => throw new PlatformNotSupportedException();

        public T GetStatic<T>(string field) => throw new PlatformNotSupportedException();

        public void CallStatic(string method, params object[] arguments) => throw new PlatformNotSupportedException();

        public T CallStatic<T>(string method, params object[] arguments) => throw new PlatformNotSupportedException();

        public void Dispose()
        {
        }
    }

    public class AndroidJavaClass : AndroidJavaObject
    {
        public AndroidJavaClass(string name)
        {
        }
    }

    public class AndroidJavaProxy
    {
        public AndroidJavaProxy(string javaInterface)
        {
        }
    }
}

namespace UnityEngine.Android
{
    public sealed class PermissionCallbacks
    {
        public event Action<string> PermissionGranted;
        public event Action<string> PermissionDenied;

        public void Answer(string permission, bool isGranted) => (isGranted ? PermissionGranted : PermissionDenied)(permission);
    }

    /// <summary>The tests are the user: they find what was asked, and answer.</summary>
    public static class Permission
    {
        public static readonly List<string> Asked = new List<string>();

        public static PermissionCallbacks Callbacks { get; private set; }

        public static void RequestUserPermissions(string[] permissions, PermissionCallbacks callbacks)
        {
            Asked.AddRange(permissions);
            Callbacks = callbacks;
        }
    }
}
