using System;
using System.Linq;
using System.Text;
using System.Threading;
using System.Threading.Tasks;
using Ml2Sensors.Messages;
using NUnit.Framework;
using UnityEngine;

namespace Ml2Sensors.Tests
{
    [TestFixture]
    public sealed class ServiceClientTests
    {
        private static readonly SetBoolRequest Request = new SetBoolRequest { data = true };
        private Ml2SensorStreamer _streamer;
        private ScriptedBridge _bridge;
        private Ml2ServiceClient<SetBoolRequest, SetBoolResponse> _client;
        private long _now;

        private NativeInbox Requests => _bridge.Services[0];

        private NativeInbox Responses => _bridge.Services[1];

        [SetUp]
        public void Open()
        {
            _streamer = new GameObject("scene").AddComponent<Ml2SensorStreamer>();
            _streamer.OpenBridge = changed => _bridge = new ScriptedBridge(changed);
            _streamer.Pump.Now = () => _now;
            _client = new Ml2ServiceClient<SetBoolRequest, SetBoolResponse>(_streamer, "/pause");
        }

        [TearDown]
        public void Close() => _streamer.Send("OnDestroy");

        [Test]
        public void CallAsync_Responses_EndTheirCallsInUpdateInAnyOrder()
        {
            Assert.AreEqual("call /pause std_srvs/srv/SetBool", _bridge.Calls.Single());
            var first = _client.CallAsync(Request, timeout: 2f);
            var second = _client.CallAsync(Request, timeout: 0.5f);
            Assert.AreEqual(new byte[] { 0, 1, 0, 0, 1 }, Requests.Take(out long timeoutNanos));
            Assert.AreEqual(2000000000, timeoutNanos);
            uint number = Requests.LastNumber;
            Requests.Take();
            Respond("later", Requests.LastNumber);
            Assert.IsFalse(second.IsCompleted);
            Update();
            Assert.IsFalse(first.IsCompleted);
            Assert.AreEqual("later", second.Result.Response.message);
            Respond("paused", number);
            Respond("twice", number);
            Update();
            Assert.IsTrue(first.Result.Response.success);
            Assert.AreEqual("paused", first.Result.Response.message);
            Assert.AreEqual(ServiceFailure.None, first.Result.Failure);
        }

        [Test]
        public void CallAsync_EachFailure_IsAValueWithItsReason()
        {
            foreach (ServiceFailure failure in Enum.GetValues(typeof(ServiceFailure)))
            {
                if (failure == ServiceFailure.None) continue;
                var call = _client.CallAsync(Request, 1);
                Requests.Take();
                byte[] bytes = new[] { (byte)failure }.Concat(Encoding.UTF8.GetBytes("nö")).ToArray();
                Responses.Add(bytes, bytes.Length, Requests.LastNumber);
                Update();
                AssertFails(call, failure, "nö");
            }
        }

        [Test]
        public void CallAsync_MalformedResponse_IsAFailureOfItsCallAlone()
        {
            byte[] whole = { 0, 1, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, (byte)'o', (byte)'k', 0 };
            for (int length = 1; length < whole.Length; length++)
            {
                var call = _client.CallAsync(Request, 1);
                Requests.Take();
                Responses.Add(whole, length, Requests.LastNumber);
                Update();
                AssertFails(call, ServiceFailure.Malformed, "expected");
            }
        }

        [Test]
        public void CallAsync_MoreThanMayBeUnderWay_IsBusy()
        {
            var calls = Enumerable.Range(0, 65).Select(_ => _client.CallAsync(Request, 1)).ToArray();
            AssertFails(calls[64], ServiceFailure.Busy, "64 calls");
            for (int i = 0; i < 64; i++)
            {
                Requests.Take();
                Respond("" + i, Requests.LastNumber);
            }
            Assert.IsNull(Requests.Take());
            for (int frame = 0; frame < 64; frame++) Update(); // Also without time: none is replaced
            Assert.AreEqual(Enumerable.Range(0, 64).Select(i => "" + i), calls.Take(64).Select(it => it.Result.Response.message));
            Assert.IsFalse(_client.CallAsync(Request, 1).IsCompleted);
        }

        [Test]
        public void Update_WithoutTime_KeepsAllResponses()
        {
            var calls = Enumerable.Range(0, 3).Select(_ => _client.CallAsync(Request, 1)).ToArray();
            for (uint number = 1; number <= 3; number++) Respond("" + number, number);
            _streamer.Pump.Now = () => _now += System.Diagnostics.Stopwatch.Frequency;
            Update();
            Assert.IsFalse(calls.Any(it => it.IsCompleted));
            _streamer.Pump.Now = () => 0;
            Update();
            Assert.IsTrue(calls.All(it => it.IsCompleted));
        }

        [Test]
        public void CallAsync_Cancelled_EndsAndItsResponseIsIgnored()
        {
            using (var source = new CancellationTokenSource())
            {
                var call = _client.CallAsync(Request, 1, source.Token);
                source.Cancel();
                Assert.IsTrue(call.IsCanceled);
                Requests.Take();
                Respond("late", Requests.LastNumber);
                Update();
                Assert.IsTrue(_client.CallAsync(Request, 1, source.Token).IsCanceled);
                Assert.IsNull(Requests.Take());
            }
        }

        [Test]
        public void Dispose_CallsUnderWayAndLaterOnes_AreRefused()
        {
            var before = _client.CallAsync(Request, 1);
            _client.Dispose();
            _client.Dispose();
            AssertFails(before, ServiceFailure.Refused, "disposed");
            AssertFails(_client.CallAsync(Request, 1), ServiceFailure.Refused, "disposed");
            Assert.AreEqual(1, _bridge.Calls.Count(it => it == "close service"));
        }

        [Test]
        public void OnDestroy_OfTheStreamer_EndsCallsUnderWay()
        {
            var call = _client.CallAsync(Request, 1);
            _streamer.Send("OnDestroy");
            AssertFails(call, ServiceFailure.LinkDown, "destroyed");
            _client.Dispose();
        }

        [Test]
        public void CallAsync_WithoutAHeadset_FailsAtOnce()
        {
            var streamer = new GameObject("other").AddComponent<Ml2SensorStreamer>();
            streamer.OpenBridge = changed => new Bridge.UnavailableBridge("no headset");
            var client = new Ml2ServiceClient<SetBoolRequest, SetBoolResponse>(streamer, "/pause");
            AssertFails(client.CallAsync(Request, 1), ServiceFailure.LinkDown, "no headset");
        }

        [Test]
        public void Misuse_Throws()
        {
            foreach (float timeout in new[] { 0, -1, float.NaN, float.PositiveInfinity })
                Assert.Throws<ArgumentException>(() => _client.CallAsync(Request, timeout).ToString());
            Assert.Throws<ArgumentException>(() => new Ml2ServiceClient<SetBoolResponse, SetBoolResponse>(_streamer, "/pause").ToString());
            Assert.Throws<ArgumentException>(() => new Ml2ServiceClient<SetBoolRequest, StringMsg>(_streamer, "/pause").ToString());
        }

        /// <summary>Frames with a client but no call allocate nothing.</summary>
        [Test]
        public void Update_WithoutCalls_MakesNoGarbage()
        {
            Action update = _streamer.Bind("Update");
            for (int i = 0; i < 10; i++) update();
            long before = GC.GetAllocatedBytesForCurrentThread();
            for (int i = 0; i < 100; i++) update();
            Assert.AreEqual(0, GC.GetAllocatedBytesForCurrentThread() - before);
        }

        private static void AssertFails(Task<ServiceResult<SetBoolResponse>> call, ServiceFailure failure, string reason)
        {
            Assert.IsTrue(call.IsCompleted);
            Assert.AreEqual(failure, call.Result.Failure);
            StringAssert.Contains(reason, call.Result.Reason);
            Assert.IsNull(call.Result.Response);
        }

        private void Respond(string message, uint number)
        {
            var cdr = new CdrWriter();
            cdr.WritePayload(new SetBoolResponse { success = true, message = message });
            Responses.Add(cdr.Buffer, cdr.Length, number);
        }

        private void Update() => _streamer.Send("Update");
    }
}
