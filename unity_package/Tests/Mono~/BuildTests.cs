using System.IO;
using System.Linq;
using NUnit.Framework;
using UnityEditor;
using UnityEditor.Build;
using UnityEditor.Build.Reporting;
using UnityEngine;

namespace Ml2Sensors.Editor.Tests
{
    [TestFixture]
    public sealed class BuildTests
    {
        [Test]
        public void BuildValidator_DefaultSettings_StopsAndroidBuildsUntilFixed()
        {
            var gate = new BuildValidator();
            var android = new BuildReport { summary = new BuildSummary { platform = BuildTarget.Android } };
            var error = Assert.Throws<BuildFailedException>(() => gate.OnPreprocessBuild(android));
            foreach (BuildCheck check in BuildCheck.All)
            {
                StringAssert.Contains(check.Problem, error.Message);
                check.Fix();
            }
            Assert.DoesNotThrow(() => gate.OnPreprocessBuild(android));
        }

        [Test]
        public void BuildValidator_OtherPlatform_IsNoConcern() => Assert.DoesNotThrow(() => new BuildValidator().OnPreprocessBuild(
            new BuildReport { summary = new BuildSummary { platform = BuildTarget.StandaloneLinux64 } }));

        [Test]
        public void ManifestPermissions_ChosenStreams_AreDeclaredOnceHoweverOftenBuilt()
        {
            var config = ScriptableObject.CreateInstance<Ml2SensorConfig>();
            foreach (StreamId stream in new[] { StreamId.HandLeft, StreamId.WorldRight, StreamId.WorldLeft, StreamId.Battery })
                config.Add(new StreamRequest { Stream = stream });
            Ml2SensorSettings.instance.Set("", config);
            string project = Path.Combine(Path.GetTempPath(), Path.GetRandomFileName());
            string file = Path.Combine(project, "src", "main", "AndroidManifest.xml");
            Directory.CreateDirectory(Path.GetDirectoryName(file));
            File.WriteAllText(file, "<manifest xmlns:android=\"http://schemas.android.com/apk/res/android\"><application/></manifest>");
            for (int i = 0; i < 2; i++) new ManifestPermissions().OnPostGenerateGradleAndroidProject(project);
            string merged = File.ReadAllText(file);
            Directory.Delete(project, true);
            Assert.AreEqual(
                new[] { "android.permission.CAMERA", "com.magicleap.permission.HAND_TRACKING" },
                merged.Split('"').Where(word => word.Contains(".permission.")).ToArray());
        }
    }
}
