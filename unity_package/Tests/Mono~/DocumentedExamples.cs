using System.Threading;
using System.Threading.Tasks;
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

        internal static void Subscribe(Ml2SensorStreamer streamer)
        {
            var joints = new Ml2Subscriber<JointStateMsg>(streamer, "/joint_states");
            joints.Received += message => Debug.Log(message.position[0]);
        }

        internal static async Task Call(Ml2SensorStreamer streamer, SetBoolRequest request, CancellationToken token)
        {
            var client = new Ml2ServiceClient<SetBoolRequest, SetBoolResponse>(streamer, "/pause");
            var result = await client.CallAsync(request, timeout: 2f, token);
            Debug.Log(result.Failure == ServiceFailure.None ? result.Response.message : result.Reason);
        }
    }
}
