using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Reflection;
using Ml2Sensors.Messages;
using NUnit.Framework;
using UnityEngine;

namespace Ml2Sensors.Tests
{
    [TestFixture]
    public sealed class SubscriberTests
    {
        private Ml2SensorStreamer _streamer;
        private ScriptedBridge _bridge;
        private long _nowMillis;

        [SetUp]
        public void Open()
        {
            _streamer = new GameObject("scene").AddComponent<Ml2SensorStreamer>();
            _streamer.OpenBridge = changed => _bridge = new ScriptedBridge(changed);
            _streamer.Pump.Now = () => _nowMillis * Stopwatch.Frequency / 1000;
        }

        [Test]
        public void Update_WaitingMessages_RaisesReceivedInTheirOrder()
        {
            using (var subscriber = Subscribe<Float64Msg>(3, out NativeInbox inbox))
            {
                var found = new List<double>();
                subscriber.Received += message => found.Add(message.data);
                for (int i = 1; i <= 4; i++) inbox.Add(new Float64Msg { data = i });
                _streamer.Send("Update");
                _streamer.Send("Update");
                Assert.AreEqual(new[] { 2.0, 3, 4 }, found.ToArray());
                Assert.AreEqual(3, subscriber.Count);
                Assert.AreEqual(1, subscriber.LeftOut);
                Assert.AreEqual(4000, subscriber.PublishedNanos);
                Assert.AreEqual("no such topic", subscriber.Refusal);
            }
            Assert.AreEqual($"subscribe /topic std_msgs/msg/Float64 {new Float64Msg().RosHash} 3", _bridge.Calls[0]);
            Assert.AreEqual("unsubscribe", _bridge.Calls[1]);
        }

        [Test]
        public void Update_MalformedMessage_IsCountedAndTheNextOneCome()
        {
            using (var subscriber = Subscribe<PathMsg>(9, out NativeInbox inbox))
            {
                int poses = 0;
                subscriber.Received += message => poses += message.poses.Length;
                inbox.Add(new byte[] { 0, 1, 0, 0, 1, 2, 3, 4, 5 }, 9);
                inbox.Add(new byte[] { 7 }, 1);
                inbox.Add(new PathMsg { poses = new[] { new PoseStampedMsg() } });
                _streamer.Send("Update");
                Assert.AreEqual(1, poses);
                Assert.AreEqual(2, subscriber.Malformed);
                Assert.AreEqual("message at byte 0: expected encapsulation 00 01, found 07", subscriber.Error.ToString());
            }
        }

        [Test]
        public void Update_MoreThanAFrameHasTimeFor_NewestWinsAndTheRestIsCounted()
        {
            using (var subscriber = Subscribe<Int32Msg>(100, out NativeInbox inbox))
            {
                var found = new List<int>();
                subscriber.Received += message =>
                {
                    found.Add(message.data);
                    _nowMillis += 2;
                };
                for (int i = 1; i <= 50; i++) inbox.Add(new Int32Msg { data = i });
                _streamer.Send("Update");
                _streamer.Send("Update");
                _streamer.Send("Update");
                Assert.AreEqual(new[] { 1, 50 }, found.ToArray());
                Assert.AreEqual(48, subscriber.LeftOut);
            }
        }

        [Test]
        public void Update_SlowSubscriber_TakesNoOthersTurn()
        {
            using (var slow = Subscribe<Int32Msg>(1, out NativeInbox slowInbox))
            using (var other = Subscribe<Int32Msg>(1, out NativeInbox otherInbox))
            {
                slow.Received += message => _nowMillis += 2;
                for (int i = 0; i < 4; i++)
                {
                    slowInbox.Add(new Int32Msg());
                    otherInbox.Add(new Int32Msg());
                    _streamer.Send("Update");
                }
                Assert.GreaterOrEqual(other.Count, 2);
                Assert.AreEqual(4, slow.Count);
            }
        }

        [Test]
        public void Update_ReceivedDisposesItsSubscriber_EndsIt()
        {
            var first = Subscribe<Int32Msg>(5, out NativeInbox inbox);
            using (var second = Subscribe<Int32Msg>(5, out NativeInbox secondInbox))
            {
                first.Received += message => first.Dispose();
                inbox.Add(new Int32Msg());
                inbox.Add(new Int32Msg());
                secondInbox.Add(new Int32Msg());
                _streamer.Send("Update");
                _streamer.Send("Update");
                Assert.AreEqual(1, first.Count);
                Assert.AreEqual(1, second.Count);
                Assert.AreEqual("", first.Refusal);
            }
        }

        /// <summary>1 kHz of 100 B and 30 Hz of 1 MB, at 60 frames per second.</summary>
        [Test]
        public void Update_SmallAndLargeMessages_MakesNoGarbageAndLosesNothing()
        {
            using (var small = Subscribe<TwistStampedMsg>(100, out NativeInbox smallInbox))
            using (var large = Subscribe<PointCloud2Msg>(2, out NativeInbox largeInbox))
            {
                var twist = new TwistStampedMsg();
                twist.header.frame_id = "a frame's name, which others share";
                var cloud = new PointCloud2Msg { data = new byte[1 << 20], fields = new[] { new PointFieldMsg { name = "x" } } };
                long sum = 0;
                small.Received += message => sum++;
                large.Received += message => sum += message.data.Length;
                long allocated = 0, ticks = 0;
                Action update = _streamer.Bind("Update");
                for (int frame = 0; frame < 120; frame++)
                {
                    for (int i = 0; i < 17; i++) smallInbox.Add(twist);
                    if (frame % 2 == 0) largeInbox.Add(cloud);
                    long before = GC.GetAllocatedBytesForCurrentThread(), started = Stopwatch.GetTimestamp();
                    update();
                    if (frame < 10) continue;
                    ticks += Stopwatch.GetTimestamp() - started;
                    allocated += GC.GetAllocatedBytesForCurrentThread() - before;
                }
                Console.WriteLine($"{1e3 * ticks / Stopwatch.Frequency / 110:0.000} ms in each frame");
                Assert.AreEqual(120 * 17, small.Count);
                Assert.AreEqual(60, large.Count);
                Assert.AreEqual(small.Count + large.Count * (1 << 20), sum);
                Assert.AreEqual(0, allocated);
            }
        }

        [Test]
        public void Update_SampleRobotSpeaks_ShowsTextAndJointsAndFollowsThePose()
        {
            Samples.RobotSpeaks sample = RobotSpeaks(out TextMesh text, out Transform marker);
            var pose = new PoseStampedMsg();
            pose.pose.position.x = 1; // Forward: z of Unity
            pose.pose.orientation.w = 1;
            _bridge.Inboxes[0].Add(new JointStateMsg { name = new[] { "elbow", "wrist" }, position = new[] { Math.PI / 2 } });
            _bridge.Inboxes[1].Add(new StringMsg { data = "hello" });
            _bridge.Inboxes[2].Add(pose);
            _streamer.Send("Update");
            Assert.AreEqual("hello\nelbow 90°", text.text);
            Assert.AreEqual(1, marker.position.z);
            pose.pose.position.x = 9;
            pose.pose.orientation.w = 0; // No rotation
            _bridge.Inboxes[2].Add(pose);
            _streamer.Send("Update");
            Assert.AreEqual(1, marker.position.z);
            sample.enabled = false;
            Assert.AreEqual(3, _bridge.Calls.FindAll(call => call == "unsubscribe").Count);
        }

        [Test]
        public void Update_SampleRobotSpeaks_ShowsTheAnswerOfItsCallUntilItIsDisabled()
        {
            Samples.RobotSpeaks sample = RobotSpeaks(out TextMesh text, out _);
            CollectionAssert.Contains(_bridge.Calls, "call /robot_status std_srvs/srv/Trigger");
            Assert.AreEqual(new byte[] { 0, 1, 0, 0, 0 }, _bridge.Services[0].Take());
            var response = new CdrWriter();
            response.WritePayload(new TriggerResponse { success = true, message = "well" });
            _bridge.Services[1].Add(response.Buffer, response.Length, 1);
            _bridge.Inboxes[1].Add(new StringMsg { data = "hello" });
            _streamer.Send("Update");
            Assert.AreEqual("well\nhello", text.text);
            sample.enabled = false;
            sample.enabled = true;
            byte[] failure = { (byte)ServiceFailure.Unavailable, (byte)'g', (byte)'o', (byte)'n', (byte)'e' };
            _bridge.Services[1].Add(failure, failure.Length, 1);
            _streamer.Send("Update");
            Assert.AreEqual("no answer: gone\nhello", text.text);
            sample.enabled = false;
            sample.enabled = true;
            sample.enabled = false; // With a call under way
            Assert.AreEqual("no answer: gone\nhello", text.text);
            Assert.AreEqual(3, _bridge.Calls.FindAll(call => call == "close service").Count);
        }

        [Test]
        public void Constructor_GreatestRate_IsAskedOfTheReceiver()
        {
            new Ml2Subscriber<Int32Msg>(_streamer, "/topic", 1, 2.5).Dispose();
            StringAssert.EndsWith(" 1 2.5 Hz", _bridge.Calls[0]);
        }

        [Test]
        public void Constructor_WithoutAHeadset_ReceivesNothing()
        {
            _streamer.OpenBridge = changed => new Bridge.UnavailableBridge("no headset");
            using (var subscriber = new Ml2Subscriber<Int32Msg>(_streamer, "/topic"))
            {
                _streamer.Send("Update");
                Assert.AreEqual("no headset", subscriber.Refusal);
            }
        }

        [Test]
        public void Constructor_DepthOrRateThatCannotBe_Throws()
        {
            Assert.Throws<ArgumentException>(() => new Ml2Subscriber<Int32Msg>(_streamer, "/topic", 0));
            Assert.Throws<ArgumentException>(() => new Ml2Subscriber<Int32Msg>(_streamer, "/topic", 101));
            foreach (double rate in new[] { -1, double.NaN, double.PositiveInfinity })
                Assert.Throws<ArgumentException>(() => new Ml2Subscriber<Int32Msg>(_streamer, "/topic", maxHz: rate));
        }

        private Samples.RobotSpeaks RobotSpeaks(out TextMesh text, out Transform marker)
        {
            text = new TextMesh();
            marker = new Transform();
            var sample = new GameObject("sample").AddComponent<Samples.RobotSpeaks>();
            foreach (var field in new Dictionary<string, object> { { "_streamer", _streamer }, { "_text", text }, { "_marker", marker } })
                sample.GetType().GetField(field.Key, BindingFlags.Instance | BindingFlags.NonPublic).SetValue(sample, field.Value);
            sample.enabled = true;
            return sample;
        }

        private Ml2Subscriber<T> Subscribe<T>(int depth, out NativeInbox inbox) where T : class, IReadable, new()
        {
            var subscriber = new Ml2Subscriber<T>(_streamer, "/topic", depth);
            inbox = _bridge.Inboxes[_bridge.Inboxes.Count - 1];
            return subscriber;
        }
    }
}
