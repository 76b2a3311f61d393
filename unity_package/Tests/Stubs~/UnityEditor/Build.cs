using System;

namespace UnityEditor
{
    public enum BuildTarget
    {
        Android = 13,
        StandaloneLinux64 = 24,
    }

    public enum AndroidSdkVersions
    {
        AndroidApiLevel22 = 22,
        AndroidApiLevel29 = 29,
        AndroidApiLevel32 = 32,
    }

    [Flags]
    public enum AndroidArchitecture : uint
    {
        ARM64 = 2,
        X86_64 = 8,
    }

    public enum ScriptingImplementation
    {
        Mono2x,
        IL2CPP,
    }

    public sealed class BuildPlayerOptions
    {
        public string[] scenes { get; set; }
        public string locationPathName { get; set; }
        public BuildTarget target { get; set; }
    }

    public static class BuildPipeline
    {
        public static Build.Reporting.BuildReport BuildPlayer(BuildPlayerOptions options) => new Build.Reporting.BuildReport();
    }

    public static class PlayerSettings
    {
        private static ScriptingImplementation _backend;

        public static ScriptingImplementation GetScriptingBackend(Build.NamedBuildTarget target) => _backend;

        public static void SetScriptingBackend(Build.NamedBuildTarget target, ScriptingImplementation backend) => _backend = backend;

        public static class Android
        {
            public static AndroidSdkVersions minSdkVersion { get; set; } = AndroidSdkVersions.AndroidApiLevel22;
            public static AndroidArchitecture targetArchitectures { get; set; } = AndroidArchitecture.ARM64;
        }
    }
}

namespace UnityEditor.Build
{
    public struct NamedBuildTarget
    {
        public static readonly NamedBuildTarget Android;
    }

    public sealed class BuildFailedException : Exception
    {
        public BuildFailedException(string message) : base(message)
        {
        }
    }

    public interface IOrderedCallback
    {
        int callbackOrder { get; }
    }

    public interface IPreprocessBuildWithReport : IOrderedCallback
    {
        void OnPreprocessBuild(Reporting.BuildReport report);
    }
}

namespace UnityEditor.Build.Reporting
{
    public enum BuildResult
    {
        Unknown,
        Succeeded,
    }

    public struct BuildSummary
    {
        public BuildResult result { get; set; }
        public BuildTarget platform { get; set; }
    }

    public class BuildReport
    {
        public BuildSummary summary { get; set; }
    }
}

namespace UnityEditor.Android
{
    public interface IPostGenerateGradleAndroidProject : UnityEditor.Build.IOrderedCallback
    {
        void OnPostGenerateGradleAndroidProject(string path);
    }
}
