using System;
using System.Collections.Generic;
using UnityEditor;
using UnityEditor.Build;

namespace Ml2Sensors.Editor
{
    /// <summary>Something the headset needs of the player settings, and how to give it.</summary>
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
                "Minimum API level must be 29 (Android 10), the headset's.",
                () => (int)PlayerSettings.Android.minSdkVersion >= 29,
                () => PlayerSettings.Android.minSdkVersion = AndroidSdkVersions.AndroidApiLevel29),
            new BuildCheck(
                "Target architecture must be x86-64 alone, the headset's.",
                () => PlayerSettings.Android.targetArchitectures == AndroidArchitecture.X86_64,
                () => PlayerSettings.Android.targetArchitectures = AndroidArchitecture.X86_64),
            new BuildCheck(
                "Scripting backend must be IL2CPP: Unity has no Mono for 64 bits on Android.",
                () => PlayerSettings.GetScriptingBackend(NamedBuildTarget.Android) == ScriptingImplementation.IL2CPP,
                () => PlayerSettings.SetScriptingBackend(NamedBuildTarget.Android, ScriptingImplementation.IL2CPP)),
        };

        public bool IsGood => _isGood();

        public void Fix() => _fix();
    }
}
