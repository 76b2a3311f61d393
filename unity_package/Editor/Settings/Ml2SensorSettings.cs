using UnityEditor;
using UnityEngine;

namespace Ml2Sensors.Editor
{
    /// <summary>Settings of the project: the defaults of new streamers, and the streams whose permissions the app declares.</summary>
    [FilePath("ProjectSettings/Ml2SensorSettings.asset", FilePathAttribute.Location.ProjectFolder)]
    internal sealed class Ml2SensorSettings : ScriptableSingleton<Ml2SensorSettings>
    {
        [SerializeField] private string _receiver = "";
        [SerializeField] private Ml2SensorConfig _config;

        public string Receiver => _receiver;

        public Ml2SensorConfig Config => _config;

        public void Set(string receiver, Ml2SensorConfig config)
        {
            _receiver = receiver;
            _config = config;
            Save(true);
        }
    }
}
