using System.Linq;
using UnityEditor;
using UnityEditor.Build;
using UnityEditor.Build.Reporting;

namespace Ml2Sensors.Editor
{
    /// <summary>Stops an Android build that could not run on the headset.</summary>
    internal sealed class BuildGate : IPreprocessBuildWithReport
    {
        public int callbackOrder => 0;

        public void OnPreprocessBuild(BuildReport report)
        {
            if (report.summary.platform != BuildTarget.Android) return;
            string[] problems = BuildCheck.All.Where(check => !check.IsGood).Select(check => check.Problem).ToArray();
            if (problems.Length == 0) return;
            throw new BuildFailedException(
                $"ML2 Sensors: {string.Join(" ", problems)} Project Settings > ML2 Sensors has a button that sets it.");
        }
    }
}
