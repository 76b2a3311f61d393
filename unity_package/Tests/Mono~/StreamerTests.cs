using System.Collections.Generic;
using System.Linq;
using Ml2Sensors.Messages;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.Android;

namespace Ml2Sensors.Tests
{
    /// <summary>Tests the streamer with a scripted bridge.</summary>
    [TestFixture]
    public sealed class StreamerTests
    {
        private const string Connected = "{'state': 'connected', 'receiver': 'lab', 'streams': {'world_left': {'state': 'running', 'values': {'update_rate': 30}}}}";
        private const string CameraNeeded = "[{'permission': 'android.permission.CAMERA', 'reason': 'to stream world_left', 'streams': ['world_left']}]";

        private Ml2SensorStreamer _streamer;
        private ScriptedBridge _bridge;
        private List<string> _events;

        [SetUp]
        public void SetUp()
        {
            Permission.Asked.Clear();
            Debug.Warnings.Clear();
            _events = new List<string>();
            _streamer = new GameObject("scene").AddComponent<Ml2SensorStreamer>();
            _bridge = null;
            _streamer.OpenBridge = changed => _bridge = new ScriptedBridge(changed);
            Assert.IsNull(_streamer.Unavailable); // opens it
            _streamer.Connected += receiver => _events.Add($"connected {receiver}");
            _streamer.Disconnected += reason => _events.Add($"disconnected {reason}");
            _streamer.ConfigurationApplied += status => _events.Add($"applied {string.Join(" ", status.Streams.Keys)}");
            _streamer.StreamRefused += (stream, reason) => _events.Add($"refused {stream}: {reason}");
            _streamer.Paired += receiver => _events.Add($"paired {receiver.Name} {receiver.Fingerprint} {receiver.Address}");
            _streamer.PairingFailed += reason => _events.Add($"pairing failed: {reason}");
            _streamer.PermissionNeeded += need => _events.Add($"needs {need.Permission} {need.Reason}");
        }

        [Test]
        public void Enable_NothingNeeded_StartsAtOnceWithTheReceiverAndDefaults()
        {
            _streamer.Receiver = "10.0.0.2:9763";
            _streamer.Config = ScriptableObject.CreateInstance<Ml2SensorConfig>();
            var request = new StreamRequest { Stream = StreamId.WorldLeft };
            request.Values.Add(new StreamValue { Key = "update_rate", Value = "30" });
            _streamer.Config.Add(request);
            _streamer.enabled = true;
            AssertCalls("start \"10.0.0.2:9763\" {\"world_left\":{\"update_rate\":30}}");
        }

        [Test]
        public void Enable_Insecure_WarnsAndStartsInsecurely()
        {
            _streamer.Insecure = true;
            _streamer.enabled = true;
            AssertCalls("start \"\" {} insecure");
            Assert.AreEqual(new[] { Ml2SensorStreamer.InsecureWarning }, Debug.Warnings);
            Show("{'state': 'connecting', 'insecure': true}");
            Assert.IsTrue(_streamer.Status.IsInsecure);
        }

        [Test]
        public void Pair_BeforeAnyStart_ReachesTheLibrary()
        {
            _streamer.Pair("ml2s://desk:1?fp=0&token=0");
            _streamer.Pair(null);
            AssertCalls("pair ml2s://desk:1?fp=0&token=0", "pair ");
        }

        [Test]
        public void Pairing_Succeeded_RaisesPairedOnceWithTheLastReceiver()
        {
            _streamer.enabled = true;
            Show(Pairing(1, "running", "", "old"));
            AssertEvents();
            foreach (int _ in new[] { 1, 2 })
            {
                Show(Pairing(1, "paired", "", "old", "desk"));
            }
            AssertEvents("paired desk f-desk h-desk:1");
            Assert.AreEqual(new[] { "old", "desk" }, _streamer.Status.Pairing.Receivers.Select(receiver => receiver.Name));
        }

        [Test]
        public void Pairing_FailedTwiceForOneReason_RaisesBothFailures()
        {
            _streamer.enabled = true;
            foreach (int number in new[] { 1, 2 })
            {
                Show(Pairing(number, "failed", "wrong token"));
            }
            AssertEvents("pairing failed: wrong token", "pairing failed: wrong token");
        }

        [Test]
        public void Pairing_OfAnEarlierRun_IsInTheStatusWithoutAnEvent()
        {
            Show(Pairing(0, "none", "", "desk"));
            AssertEvents();
            Assert.AreEqual("desk", _streamer.Status.Pairing.Receivers.Single().Name);
        }

        [Test]
        public void Status_FromAnotherThread_BecomesEventsInTheNextUpdateAndOnce()
        {
            _streamer.enabled = true;
            _bridge.RaiseStatus(Connected);
            AssertEvents();
            Update();
            AssertEvents("connected lab", "applied world_left");
            Show(Connected);
            AssertEvents("connected lab", "applied world_left");
            Assert.AreEqual("30", _streamer.Status.Streams["world_left"].Values["update_rate"]);
        }

        [Test]
        public void Status_SeveralBetweenUpdates_OnlyTheLatestCounts()
        {
            _streamer.enabled = true;
            _bridge.RaiseStatus("{'state': 'connecting'}");
            _bridge.RaiseStatus(Connected);
            Show("{'state': 'connecting', 'reason': 'link lost'}");
            AssertEvents();
            Assert.AreEqual(ConnectionState.Connecting, _streamer.Status.State);
        }

        [Test]
        public void Status_ConnectionLost_RaisesDisconnectedThenConnected()
        {
            _streamer.enabled = true;
            foreach (string said in new[] { Connected, "{'state': 'connecting', 'reason': 'link lost'}", Connected })
            {
                Show(said);
            }
            AssertEvents("connected lab", "applied world_left", "disconnected link lost", "connected lab", "applied world_left");
        }

        [TestCase("refused", StreamState.Refused)]
        [TestCase("waiting", StreamState.Waiting)]
        public void Status_StreamDoesNotRun_RaisesStreamRefusedOncePerReason(string state, StreamState expected)
        {
            _streamer.enabled = true;
            string status = $"{{'state': 'connected', 'streams': {{'depth': {{'state': '{state}', 'reason': 'no sensor'}}}}}}";
            Show(status);
            Show(status);
            Assert.AreEqual(1, _events.Count(e => e == "refused depth: no sensor"));
            Assert.AreEqual(expected, _streamer.Status.Streams["depth"].State);
        }

        [Test]
        public void Enable_PermissionNeeded_RequestsItOnceWithTheReasonAndWaits()
        {
            Need(CameraNeeded);
            _streamer.enabled = true;
            AssertEvents("needs android.permission.CAMERA to stream world_left");
            Assert.AreEqual(new[] { "android.permission.CAMERA" }, Permission.Asked);
            Update();
            AssertCalls();
            Permission.Callbacks.Answer("android.permission.CAMERA", true);
            Update();
            Update();
            AssertCalls("start \"\" {}");
        }

        [Test]
        public void Enable_PermissionDenied_StillStarts()
        {
            EnableAndDenyCamera();
            AssertCalls("start \"\" {}");
        }

        [Test]
        public void Status_RefusedForAPermission_RequestsItAndRestartsWhenGranted()
        {
            _streamer.enabled = true;
            _bridge.Needs = CameraNeeded;
            Show("{'state': 'connected', 'streams': {'world_left': {'state': 'refused', 'reason': 'permission'}}}");
            Permission.Callbacks.Answer("android.permission.CAMERA", true);
            Update();
            AssertCalls("start \"\" {}", "start \"\" {}");
        }

        [Test]
        public void Lifecycle_PauseResumeQuit_ReachesTheLibraryInOrder()
        {
            _streamer.Send("OnApplicationPause", true);
            _streamer.enabled = true;
            _streamer.Send("OnApplicationPause", true);
            _streamer.Send("OnApplicationPause", false);
            _streamer.enabled = false;
            _streamer.Send("OnDestroy");
            AssertCalls("start \"\" {}", "pause", "resume", "stop", "close");
        }

        [Test]
        public void Resume_WhileStopped_ReachesTheLibraryWithTheNextStart()
        {
            _streamer.enabled = true;
            _streamer.Send("OnApplicationPause", true);
            _streamer.StopStreaming();
            _streamer.Send("OnApplicationPause", false);
            _streamer.StartStreaming();
            AssertCalls("start \"\" {}", "pause", "stop", "start \"\" {}", "resume");
        }

        [Test]
        public void Resume_OfAnObjectThatUnityDoesNotTell_ReachesTheLibraryWhenItIsEnabled()
        {
            _streamer.enabled = true;
            _streamer.Send("OnApplicationPause", true);
            _streamer.enabled = false;
            _streamer.enabled = true;
            Assert.AreEqual("resume", _bridge.Calls.Last());
        }

        [Test]
        public void PauseAndResume_AmongTheAppsOwnCallsInAnyOrder_LeaveTheLibraryAsThePlatformIs()
        {
            foreach (int seed in Enumerable.Range(1, 200))
            {
                SetUp();
                var random = new System.Random(seed);
                bool isPaused = false;
                for (int i = 0; i < 30; i++)
                {
                    int call = random.Next(4);
                    if (call == 0) _streamer.Send("OnApplicationPause", isPaused = true);
                    if (call == 1) _streamer.Send("OnApplicationPause", isPaused = false);
                    if (call == 2) _streamer.StopStreaming();
                    if (call == 3) _streamer.StartStreaming();
                }
                _streamer.StartStreaming();
                Assert.AreEqual(isPaused, _bridge.IsPaused, $"seed {seed}: {string.Join(", ", _bridge.Calls)}");
            }
        }

        [Test]
        public void Lifecycle_InAnyOrder_OpensOneLibraryAndClosesItOnceAndForGood()
        {
            foreach (int seed in Enumerable.Range(1, 200))
            {
                SetUp();
                int opened = 1;
                var open = _streamer.OpenBridge;
                _streamer.OpenBridge = changed =>
                {
                    opened++;
                    return open(changed);
                };
                ScriptedBridge bridge = _bridge;
                var publisher = new Ml2Publisher<StringMsg>(_streamer, "note");
                var random = new System.Random(seed);
                var calls = new System.Action[]
                {
                    () => _streamer.enabled = !_streamer.enabled,
                    () => _streamer.Send("OnApplicationPause", random.Next(2) == 0),
                    () => _streamer.Send("OnApplicationFocus", random.Next(2) == 0),
                    Update,
                    _streamer.StartStreaming,
                    _streamer.StopStreaming,
                    () => _streamer.Pair("ml2s://desk:1?fp=0&token=0"),
                    () => publisher.Publish(new StringMsg { data = "a" }, 42),
                    () => _streamer.AddView(StreamId.Depth),
                    () => bridge.Needs = random.Next(2) == 0 ? "[]" : CameraNeeded,
                };
                for (int i = 0; i < 20; i++) calls[random.Next(calls.Length)]();
                for (int i = 0; i < 2; i++) _streamer.Send("OnDestroy");
                for (int i = 0; i < 20; i++) calls[random.Next(calls.Length)]();
                Assert.AreEqual(1, opened, $"seed {seed}");
                Assert.AreEqual(1, bridge.Calls.Count(call => call == "close"), $"seed {seed}");
                Assert.AreEqual("close", bridge.Calls.Last(), $"seed {seed}");
                StringAssert.Contains("destroyed", _streamer.Unavailable);
            }
        }

        [TestCase("OnApplicationFocus", true)]
        [TestCase("OnApplicationPause", false)]
        public void PermissionRequest_WithoutAnAnswer_EndsWhenTheAppIsInFrontAgain(string message, bool argument)
        {
            Need(CameraNeeded);
            _streamer.enabled = true;
            _streamer.Send("OnApplicationFocus", false);
            for (int i = 0; i < 1000; i++) Update();
            AssertCalls();
            _streamer.Send(message, argument);
            Update();
            AssertCalls("start \"\" {}");
            Assert.AreEqual(1, Permission.Asked.Count, "no dialog after dialog");
            Permission.Callbacks.Answer("android.permission.CAMERA", false);
            Update();
            AssertCalls("start \"\" {}");
        }

        [Test]
        public void PermissionRequest_WithoutAnAnswer_IsMadeAgainWithTheNextStart()
        {
            Need(CameraNeeded);
            _streamer.enabled = true;
            _streamer.StopStreaming();
            _streamer.StartStreaming();
            Assert.AreEqual(1, Permission.Asked.Count, "the dialog may be open");
            _streamer.StopStreaming();
            _streamer.Send("OnApplicationFocus", true);
            _streamer.StartStreaming();
            Assert.AreEqual(2, Permission.Asked.Count);
            AssertCalls();
            _streamer.StopStreaming();
            Need("[]");
            _streamer.StartStreaming();
            AssertCalls("start \"\" {}");
        }

        [Test]
        public void PermissionGranted_OutsideTheDialog_RestartsWhenTheAppIsInFrontAgain()
        {
            EnableAndDenyCamera();
            _streamer.Send("OnApplicationFocus", true);
            Update();
            AssertCalls("start \"\" {}");
            Need("[]");
            _streamer.Send("OnApplicationFocus", true);
            Update();
            _streamer.Send("OnApplicationFocus", true);
            Update();
            AssertCalls("start \"\" {}", "start \"\" {}");
        }

        [Test]
        public void Permission_AnsweredAndLookedAt_RestartsOnce()
        {
            _streamer.enabled = true;
            Need(CameraNeeded);
            Show("{'state': 'connected', 'streams': {'world_left': {'state': 'refused', 'reason': 'permission'}}}");
            Need("[]");
            _streamer.Send("OnApplicationFocus", true);
            Update();
            Permission.Callbacks.Answer("android.permission.CAMERA", true);
            Update();
            AssertCalls("start \"\" {}", "start \"\" {}");
        }

        [Test]
        public void Disable_BeforeTheUserAnswers_NeverStarts()
        {
            Need(CameraNeeded);
            _streamer.enabled = true;
            _streamer.enabled = false;
            Permission.Callbacks.Answer("android.permission.CAMERA", true);
            Update();
            AssertCalls();
        }

        [Test]
        public void Views_OfTwoReaders_StartWithTheFirstAndEndWithTheLast()
        {
            _streamer.AddView(StreamId.Depth);
            _streamer.AddView(StreamId.Depth);
            _streamer.RemoveView(StreamId.Depth);
            _streamer.RemoveView(StreamId.Depth);
            AssertCalls("view depth True", "view depth False");
        }

        [Test]
        public void Update_WithoutANewStatus_AllocatesNothing()
        {
            _streamer.enabled = true;
            System.Action update = _streamer.Bind("Update");
            update();
            long before = System.GC.GetAllocatedBytesForCurrentThread();
            for (int i = 0; i < 1000; i++) update();
            Assert.AreEqual(0, System.GC.GetAllocatedBytesForCurrentThread() - before);
        }

        [Test]
        public void OtherPlatform_Start_WarnsAndDoesNothing()
        {
            var streamer = new GameObject("scene").AddComponent<Ml2SensorStreamer>();
            streamer.enabled = true;
            StringAssert.Contains("LinuxEditor", streamer.Unavailable);
            Assert.AreEqual(new[] { streamer.Unavailable }, Debug.Warnings);
        }

        [Test]
        public void Publisher_Message_WaitsAsCdrForTheLibrary()
        {
            var publisher = new Ml2Publisher<StringMsg>(_streamer, "operator_note", depth: 2);
            Assert.IsFalse(publisher.Publish(new StringMsg { data = "lost" }, 41));
            Show("{'state': 'connected', 'receiver': 'desk'}");
            Assert.IsTrue(publisher.Publish(new StringMsg { data = "aß" }, 42));
            Assert.AreEqual("open custom/operator_note std_msgs/msg/String 2", _bridge.Calls[0]);
            Assert.AreEqual(new byte[] { 0, 1, 0, 0, 4, 0, 0, 0, 0x61, 0xc3, 0x9f, 0 }, _bridge.Outboxes[0].Take(out long nanos));
            Assert.AreEqual(42, nanos);
            for (int i = 1; i <= 3; i++) Assert.IsTrue(publisher.Publish(new StringMsg { data = "" + i }, i));
            Assert.AreEqual((byte)'2', _bridge.Outboxes[0].Take()[8]);
            Assert.AreEqual((byte)'3', _bridge.Outboxes[0].Take()[8]);
            Assert.IsNull(_bridge.Outboxes[0].Take());
            Assert.AreEqual(1, _bridge.Outboxes[0].LeftOut);
            Assert.AreEqual("no such type", publisher.Refusal);
        }

        [Test]
        public void Publisher_KindsOfTopics_AreOpenedAsSuch()
        {
            new Ml2Publisher<TemperatureMsg>(_streamer, "/Lab/temp_1", latched: true).ToString();
            new Ml2Publisher<PointCloud2Msg>(_streamer, "cloud", large: true).ToString();
            AssertCalls(
                "open /Lab/temp_1 sensor_msgs/msg/Temperature latched stamped 10",
                "open custom/cloud sensor_msgs/msg/PointCloud2 large stamped 10");
        }

        [Test]
        public void Publisher_MessageOfMoreThanItsTopicHas_Throws()
        {
            var cloud = new PointCloud2Msg { data = new byte[1 << 16] };
            var small = new Ml2Publisher<PointCloud2Msg>(_streamer, "small");
            var large = new Ml2Publisher<PointCloud2Msg>(_streamer, "large", large: true);
            Show("{'state': 'connected', 'receiver': 'desk'}");
            StringAssert.Contains("at most 65536 bytes", Assert.Throws<System.ArgumentException>(() => small.Publish(cloud, 1)).Message);
            Assert.IsTrue(large.Publish(cloud, 1));
            Assert.AreEqual(cloud.data.Length + 49, _bridge.Outboxes[1].Take().Length);
            cloud.data = new byte[1 << 24];
            Assert.Throws<System.ArgumentException>(() => large.Publish(cloud, 1));
        }

        /// <summary>1 kHz of small messages and 30 Hz of 1 MB, at 60 frames per second.</summary>
        [Test]
        public void Publisher_SmallAndLargeMessages_MakesNoGarbageAndLosesNothing()
        {
            var small = new Ml2Publisher<TwistStampedMsg>(_streamer, "small", depth: 20);
            var large = new Ml2Publisher<PointCloud2Msg>(_streamer, "large", large: true, depth: 1);
            Show("{'state': 'connected', 'receiver': 'desk'}");
            var twist = new TwistStampedMsg();
            twist.header.frame_id = "a frame's name, which others share";
            var cloud = new PointCloud2Msg { data = new byte[1 << 20] };
            int calls = _bridge.Calls.Count, sent = 0, taken = 0;
            long allocated = 0, ticks = 0;
            for (int frame = 0; frame < 120; frame++)
            {
                long before = System.GC.GetAllocatedBytesForCurrentThread(), started = System.Diagnostics.Stopwatch.GetTimestamp();
                for (int i = 0; i < 17; i++) sent += small.Publish(twist, frame) ? 1 : 0;
                if (frame % 2 == 0) sent += large.Publish(cloud, frame) ? 1 : 0;
                if (frame >= 10)
                {
                    ticks += System.Diagnostics.Stopwatch.GetTimestamp() - started;
                    allocated += System.GC.GetAllocatedBytesForCurrentThread() - before;
                }
                foreach (NativeInbox outbox in _bridge.Outboxes)
                    while (outbox.Take() != null) taken++;
            }
            System.Console.WriteLine($"{1e3 * ticks / System.Diagnostics.Stopwatch.Frequency / 110:0.000} ms in each frame");
            Assert.AreEqual(0, allocated);
            Assert.AreEqual(120 * 17 + 60, sent);
            Assert.AreEqual(sent, taken);
            Assert.AreEqual(calls, _bridge.Calls.Count);
        }

        [TestCase("")]
        [TestCase("1st")]
        [TestCase("a/b")]
        [TestCase("Note")]
        [TestCase("/")]
        [TestCase("/a//b")]
        [TestCase("/a_")]
        [TestCase("/1")]
        public void Publisher_InvalidName_Throws(string name)
        {
            Assert.Throws<System.ArgumentException>(() => new Ml2Publisher<StringMsg>(_streamer, name).ToString());
        }

        private static string Pairing(int number, string state, string reason, params string[] receivers)
        {
            var known = receivers.Select(name => $"{{'name': '{name}', 'fingerprint': 'f-{name}', 'address': 'h-{name}:1'}}");
            return $"{{'state': 'connecting', 'pairing': {{'number': {number}, 'state': '{state}', 'reason': '{reason}', " +
                $"'receivers': [{string.Join(", ", known)}]}}}}";
        }

        private void Need(string needs) => _bridge.Needs = needs;

        private void EnableAndDenyCamera()
        {
            Need(CameraNeeded);
            _streamer.enabled = true;
            Permission.Callbacks.Answer("android.permission.CAMERA", false);
            Update();
        }

        private void Update() => _streamer.Send("Update");

        /// <summary>Raises a status on another thread, and runs the next Update.</summary>
        private void Show(string status)
        {
            _bridge.RaiseStatus(status);
            Update();
        }

        private void AssertCalls(params string[] calls) => Assert.AreEqual(calls, _bridge.Calls.ToArray());

        private void AssertEvents(params string[] events) => Assert.AreEqual(events, _events.ToArray());
    }
}
