using Ml2Sensors.Messages;
using UnityEngine;

namespace Ml2Sensors.Tests
{
    /// <summary>The examples of the documents; test_csharp_examples.py compares their words.</summary>
    internal static class DocumentedExamples
    {
        internal static void Pair(Ml2SensorStreamer streamer, string uri)
        {
            streamer.Paired += receiver => Debug.Log($"paired with {receiver.Name}");
            streamer.PairingFailed += reason => Debug.LogWarning(reason);
            streamer.Pair(uri);
        }

        internal static void Listen(Ml2SensorStreamer streamer)
        {
            streamer.Connected += receiver => Debug.Log($"streaming to {receiver}");
            streamer.StreamRefused += (stream, reason) => Debug.LogWarning($"{stream}: {reason}");
        }

        internal static void Publish(Ml2SensorStreamer streamer, Float64Msg message)
        {
            var publisher = new Ml2Publisher<Float64Msg>(streamer, "head_height"); // PREFIX/custom/head_height
            publisher.Publish(message, Ml2Publisher<Float64Msg>.NowNanos);
        }
    }
}
