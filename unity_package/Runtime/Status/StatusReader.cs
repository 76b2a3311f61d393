using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace Ml2Sensors
{
    /// <summary>Parses the JSON of the bridge. Unknown keys are ignored.</summary>
    internal static class StatusReader
    {
        /// <exception cref="FormatException">The text is not JSON, or a value has the wrong type.</exception>
        public static Status ReadStatus(string json) => Read(json, text =>
        {
            JObject root = JObject.Parse(text);
            return new Status(
                Word<ConnectionState>(root, "state"), Text(root, "receiver"), Text(root, "reason"), (bool?)root["insecure"] ?? false,
                Map(root, "streams", Stream), Map(root, "channels", Channel), Clock(root["clock"] as JObject),
                Pairing(root["pairing"] as JObject));
        });

        /// <exception cref="FormatException">The text is not JSON, or a value has the wrong type.</exception>
        public static IReadOnlyList<PermissionNeed> ReadPermissions(string json) => Read(json, text =>
            JArray.Parse(text).Select(need => new PermissionNeed(
                (string)need["permission"], (string)need["reason"] ?? "", need["streams"].Select(id => (string)id).ToArray())).ToArray());

        private static T Read<T>(string json, Func<string, T> read)
        {
            try
            {
                return read(json);
            }
            catch (Exception e) when (e is JsonException || e is InvalidCastException || e is NullReferenceException || e is ArgumentException)
            {
                throw new FormatException($"Expected a status of the library, found text that this package cannot parse ({e.Message}): {json}", e);
            }
        }

        private static StreamStatus Stream(JToken token)
        {
            var stream = (JObject)token;
            return new StreamStatus(Word<StreamState>(stream, "state"), Text(stream, "reason"), Map(stream, "values", JsonText));
        }

        private static ChannelCounts Channel(JToken token) =>
            new ChannelCounts((long)token["produced"], (long)token["sent"], Map((JObject)token, "dropped", count => (long)count));

        private static ClockStatus Clock(JObject clock)
        {
            if (clock == null || !clock.HasValues) return null;
            return new ClockStatus(Text(clock, "state"), (long?)clock["offset_ns"] ?? 0, (long?)clock["uncertainty_ns"] ?? 0);
        }

        private static PairingStatus Pairing(JObject pairing)
        {
            if (pairing == null) return PairingStatus.Initial;
            var receivers = pairing["receivers"].Select(receiver => new PairedReceiver(
                (string)receiver["name"], (string)receiver["fingerprint"], (string)receiver["address"]));
            return new PairingStatus(
                (int)pairing["number"], Word<PairingState>(pairing, "state"), Text(pairing, "reason"), receivers.ToArray());
        }

        private static T Word<T>(JObject parent, string key) where T : struct
        {
            string word = Text(parent, key);
            if (Enum.TryParse(word, true, out T value)) return value;
            throw new ArgumentException($"{key} is \"{word}\", expected one of {string.Join(", ", Enum.GetNames(typeof(T))).ToLowerInvariant()}");
        }

        private static string Text(JObject parent, string key) => (string)parent[key] ?? "";

        private static string JsonText(JToken value) =>
            value.Type == JTokenType.String ? (string)value : Convert.ToString(((JValue)value).Value, CultureInfo.InvariantCulture).ToLowerInvariant();

        private static Dictionary<string, T> Map<T>(JObject parent, string key, Func<JToken, T> read)
        {
            var entries = parent[key] as JObject ?? new JObject();
            return entries.Properties().ToDictionary(entry => entry.Name, entry => read(entry.Value));
        }
    }
}
