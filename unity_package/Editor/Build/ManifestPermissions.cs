using System.IO;
using UnityEditor.Android;

namespace Ml2Sensors.Editor
{
    /// <summary>Adds the permissions of the chosen streams to the manifest that Unity generates.</summary>
    internal sealed class ManifestPermissions : IPostGenerateGradleAndroidProject
    {
        public int callbackOrder => 0;

        /// <param name="path">The folder of the module unityLibrary.</param>
        public void OnPostGenerateGradleAndroidProject(string path)
        {
            Ml2SensorConfig config = Ml2SensorSettings.instance.Config;
            if (config == null) return;
            string file = Path.Combine(path, "src", "main", "AndroidManifest.xml");
            string before = File.ReadAllText(file);
            string after = AndroidManifest.WithPermissions(before, config.Permissions);
            if (after != before) File.WriteAllText(file, after);
        }
    }
}
