using System;
using System.Collections.Generic;
using System.Linq;
using UnityEditor;
using UnityEditor.Build;
using UnityEditor.Build.Reporting;

namespace Ml2Sensors.Editor
{
    /// <summary>A player setting that the headset requires, and how to set it.</summary>
    internal sealed class BuildCheck
    {
        public readonly string Problem;
        private readonly Func<bool> _isGood;
        private readonly Action _fix;

        private BuildCheck(string problem, Func<bool> isGood, Action fix)
        {
            Problem = problem;
            _isGood = isGood;
            _fix = fix;
        }

        public static readonly IReadOnlyList<BuildCheck> All = new[]
        {
            new BuildCheck(
                "Set the minimum API level to 29 (Android 10), the level of the headset.",
                () => (int)PlayerSettings.Android.minSdkVersion >= 29,
                () => PlayerSettings.Android.minSdkVersion = AndroidSdkVersions.AndroidApiLevel29),
            new BuildCheck(
                "Set the target architecture to x86-64 only, the processor of the headset.",
                () => PlayerSettings.Android.targetArchitectures == AndroidArchitecture.X86_64,
                () => PlayerSettings.Android.targetArchitectures = AndroidArchitecture.X86_64),
            new BuildCheck(
                "Set the scripting backend to IL2CPP: Unity's Mono does not support 64 bits on Android.",
                () => PlayerSettings.GetScriptingBackend(NamedBuildTarget.Android) == ScriptingImplementation.IL2CPP,
                () => PlayerSettings.SetScriptingBackend(NamedBuildTarget.Android, ScriptingImplementation.IL2CPP)),
        };

        public bool IsGood => _isGood();

        public void Fix() => _fix();
    }

    /// <summary>Stops an Android build whose player settings do not fit the headset.</summary>
    internal sealed class BuildValidator : IPreprocessBuildWithReport
    {
        public int callbackOrder => 0;

        public void OnPreprocessBuild(BuildReport report)
        {
            if (report.summary.platform != BuildTarget.Android) return;
            string[] problems = BuildCheck.All.Where(check => !check.IsGood).Select(check => check.Problem).ToArray();
            if (problems.Length == 0) return;
            throw new BuildFailedException(
                $"ML2 Sensors: {string.Join(" ", problems)} Use the button Fix in Project Settings > ML2 Sensors.");
        }
    }
}
