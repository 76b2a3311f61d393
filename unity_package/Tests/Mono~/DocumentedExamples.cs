using Ml2Sensors.Messages;
using UnityEngine;

namespace Ml2Sensors.Tests
{
    /// <summary>The examples in the documents; tests/docs/test_links.py compares both texts.</summary>
    internal static class DocumentedExamples
    {
        internal static void Stream(Ml2SensorStreamer streamer, string uri)
        {
            streamer.Paired += receiver => Debug.Log($"paired with {receiver.Name}");
            streamer.PairingFailed += reason => Debug.LogWarning(reason);
            streamer.Connected += receiver => Debug.Log($"streaming to {receiver}");
            streamer.StreamRefused += (stream, reason) => Debug.LogWarning($"{stream}: {reason}");
            streamer.Pair(uri);
        }

        internal static void Publish(Ml2SensorStreamer streamer, Float64Msg message)
        {
            var publisher = new Ml2Publisher<Float64Msg>(streamer, "head_height"); // PREFIX/custom/head_height
            publisher.Publish(message, Ml2Publisher<Float64Msg>.NowNanos);
        }
    }
}
