using System;
using System.Collections.Generic;
using System.Linq;
using Newtonsoft.Json;
using UnityEngine;

namespace Ml2Sensors
{
    /// <summary>
    /// The streams that run if the receiver does not choose, and whose permissions the app declares. Values that are not
    /// listed are those of the first mode of the camera's section in the stream table, with images that the app can read.
    /// </summary>
    [CreateAssetMenu(menuName = "ML2 Sensors/Sensor Config", fileName = "Ml2SensorConfig")]
    public sealed class Ml2SensorConfig : ScriptableObject
    {
        [SerializeField] private List<StreamRequest> _streams = new List<StreamRequest>();

        /// <summary>The streams, in the order of the inspector.</summary>
        public IReadOnlyList<StreamRequest> Streams => _streams;

        /// <summary>The permissions that the app must declare for its streams, in the order of the stream table.</summary>
        public IEnumerable<string> Permissions =>
            StreamTable.Rows.Where((row, id) => _streams.Any(stream => stream.Stream == (StreamId)id))
                .SelectMany(row => row.Permissions).Distinct();

        /// <summary>Adds a stream to the end of the list.</summary>
        public void Add(StreamRequest request) => _streams.Add(request);

        /// <summary>Returns the value of "streams" in CONFIGURE (PROTOCOL.md).</summary>
        public string ToJson() => JsonConvert.SerializeObject(
            _streams.ToDictionary(stream => StreamTable.Rows[(int)stream.Stream].Id, stream => stream.ToValues()));
    }

    /// <summary>A stream, with values of its section in config.yaml.</summary>
    [Serializable]
    public sealed class StreamRequest
    {
        /// <summary>The stream.</summary>
        public StreamId Stream;

        /// <summary>The values that differ from the first mode.</summary>
        [Tooltip("Keys such as resolution_width; docs/configuration.md lists them.")]
        public List<StreamValue> Values = new List<StreamValue>();

        internal Dictionary<string, object> ToValues() => Values.ToDictionary(value => value.Key, value => value.ToScalar());
    }

    /// <summary>A key of a section of config.yaml, with its value.</summary>
    [Serializable]
    public sealed class StreamValue
    {
        /// <summary>The key, such as resolution_width.</summary>
        public string Key = "";

        /// <summary>The value, as YAML writes it.</summary>
        public string Value = "";

        /// <summary>Returns the value as YAML reads it: a number, true, false or text.</summary>
        internal object ToScalar()
        {
            if (long.TryParse(Value, out long whole)) return whole;
            if (bool.TryParse(Value, out bool truth)) return truth;
            return Value;
        }
    }
}
