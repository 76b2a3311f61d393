using System;
using System.Collections.Generic;
using System.Linq;
using Newtonsoft.Json;
using UnityEngine;

namespace Ml2Sensors
{
    /// <summary>
    /// The streams that run when the receiver does not say, and those whose permissions the app declares. Values not
    /// listed are the stream table's defaults.
    /// </summary>
    [CreateAssetMenu(menuName = "ML2 Sensors/Sensor Config", fileName = "Ml2SensorConfig")]
    public sealed class Ml2SensorConfig : ScriptableObject
    {
        [SerializeField] private List<StreamRequest> _streams = new List<StreamRequest>();

        /// <summary>In the order of the list in the inspector.</summary>
        public IReadOnlyList<StreamRequest> Streams => _streams;

        /// <summary>Those that the app must declare for its streams, in the order of the stream table.</summary>
        public IEnumerable<string> Permissions =>
            StreamTable.Rows.Where((row, id) => _streams.Any(stream => stream.Stream == (StreamId)id))
                .SelectMany(row => row.Permissions).Distinct();

        /// <summary>Behind the others.</summary>
        public void Add(StreamRequest request) => _streams.Add(request);

        /// <summary>As the "streams" of PROTOCOL.md's CONFIGURE.</summary>
        public string ToJson() => JsonConvert.SerializeObject(
            _streams.ToDictionary(stream => StreamTable.Rows[(int)stream.Stream].Id, stream => stream.ToValues()));
    }

    /// <summary>One stream, and values of its section in config.yaml.</summary>
    [Serializable]
    public sealed class StreamRequest
    {
        /// <summary>Which one.</summary>
        public StreamId Stream;

        /// <summary>Those that are not the defaults.</summary>
        [Tooltip("Such as resolution_width; docs/configuration.md lists them.")]
        public List<StreamValue> Values = new List<StreamValue>();

        internal Dictionary<string, object> ToValues() => Values.ToDictionary(value => value.Key, value => value.ToScalar());
    }

    /// <summary>A key of a section of config.yaml, with its value.</summary>
    [Serializable]
    public sealed class StreamValue
    {
        /// <summary>Such as resolution_width.</summary>
        public string Key = "";

        /// <summary>As YAML writes it.</summary>
        public string Value = "";

        /// <summary>As YAML reads it: a number, true or false, else text.</summary>
        internal object ToScalar()
        {
            if (long.TryParse(Value, out long whole)) return whole;
            if (bool.TryParse(Value, out bool truth)) return truth;
            return Value;
        }
    }
}
