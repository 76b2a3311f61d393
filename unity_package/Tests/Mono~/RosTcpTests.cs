using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading.Tasks;
using Ml2Sensors.Messages;
using Ml2Sensors.RosTcp;
using NUnit.Framework;
using RosMessageTypes.Workshop;
using Unity.Robotics.ROSTCPConnector.MessageGeneration;
using UnityEngine;

namespace RosMessageTypes.Workshop
{
    /// <summary>A class in the manner of the connector's generator, with the fields of geometry_msgs/Point behind a text.</summary>
    public sealed class WaypointMsg : Message
    {
        public const string k_RosMessageName = "workshop/Waypoint";
        public string name = "";
        public double x, y, z;

        public override string RosMessageName => k_RosMessageName;

        public static WaypointMsg Deserialize(MessageDeserializer deserializer)
        {
            var message = new WaypointMsg();
            deserializer.Read(out message.name);
            deserializer.Read(out message.x);
            deserializer.Read(out message.y);
            deserializer.Read(out message.z);
            return message;
        }

        public override void SerializeTo(MessageSerializer serializer)
        {
            serializer.Write(name);
            serializer.Write(x);
            serializer.Write(y);
            serializer.Write(z);
        }
    }

    public sealed class PictureMsg : Message
    {
        public byte[] data = new byte[0];

        public override string RosMessageName => "workshop/Picture";

        public override void SerializeTo(MessageSerializer serializer)
        {
        }
    }

    public sealed class PlanMsg : Message
    {
        public override string RosMessageName => "workshop/Plan";

        public override void SerializeTo(MessageSerializer serializer)
        {
        }
    }

    public sealed class OtherMsg : Message
    {
        public override string RosMessageName => "workshop/Other";

        public override void SerializeTo(MessageSerializer serializer)
        {
        }
    }
}

namespace Ml2Sensors.Tests
{
    /// <summary>A publisher in the manner of Unity's tutorials, whose using alone was changed.</summary>
    internal sealed class WaypointSender : MonoBehaviour
    {
        public string topic = "waypoint";
        public GameObject marker;
        private ROSConnection _ros;

        private void Start()
        {
            _ros = ROSConnection.GetOrCreateInstance();
            _ros.RegisterPublisher<WaypointMsg>(topic);
        }

        private void Update()
        {
            UnityEngine.Vector3 position = marker.transform.position;
            _ros.Publish(topic, new WaypointMsg { name = "marker", x = position.x, y = position.y, z = position.z });
        }
    }

    /// <summary>A subscriber in the same manner.</summary>
    internal sealed class WaypointFollower : MonoBehaviour
    {
        public GameObject marker;

        private void Start() => ROSConnection.GetOrCreateInstance().Subscribe<WaypointMsg>("waypoint", Follow);

        private void Follow(WaypointMsg message) =>
            marker.transform.position = new UnityEngine.Vector3((float)message.x, (float)message.y, (float)message.z);
    }

    [TestFixture]
    public sealed class RosTcpTests
    {
        private Ml2SensorStreamer _streamer;
        private ScriptedBridge _bridge;

        /// <summary>Unity calls Register of each class that the connector generated.</summary>
        [SetUp]
        public void Open()
        {
            GameObject.UnloadAll();
            Debug.Warnings.Clear();
            Debug.Exceptions.Clear();
            MessageRegistry.Register(WaypointMsg.k_RosMessageName, WaypointMsg.Deserialize);
            _streamer = new GameObject("scene").AddComponent<Ml2SensorStreamer>();
            _streamer.OpenBridge = changed => _bridge = new ScriptedBridge(changed);
            _streamer.Pump.Now = () => 0;
        }

        [Test]
        public void Publish_ByAScriptOfTheConnector_SendsItsFields()
        {
            var sender = new GameObject("sender").AddComponent<WaypointSender>();
            sender.marker = new GameObject("marker");
            sender.marker.AddComponent<WaypointFollower>();
            sender.marker.transform.position = new UnityEngine.Vector3(1, 2, 3);
            sender.Send("Start");
            sender.Send("Update");
            Assert.AreEqual(new[] { "open /waypoint workshop/msg/Waypoint 10" }, _bridge.Calls.ToArray());
            Assert.IsNull(_bridge.Outboxes[0].Take());
            Connect();
            sender.Send("Update");
            Assert.AreEqual(Payload("marker", 1, 2, 3), _bridge.Outboxes[0].Take());
        }

        [Test]
        public void Publish_MessageWithoutFields_HasTheByteThatRosExpects()
        {
            ROSConnection ros = ROSConnection.GetOrCreateInstance();
            RosTopicState empty = ros.RegisterPublisher("empty", "workshop/Other");
            Connect();
            empty.Publish(new OtherMsg());
            Assert.AreEqual(new byte[] { 0, 1, 0, 0, 0 }, _bridge.Outboxes[0].Take());
        }

        [Test]
        public void RegisterPublisher_LatchedOrWithBytes_OpensSuchATopic()
        {
            MessageRegistry.Register("workshop/Picture", _ => new PictureMsg());
            ROSConnection ros = ROSConnection.GetOrCreateInstance();
            ros.RegisterPublisher<WaypointMsg>("goal", 1, true);
            ros.RegisterPublisher<PictureMsg>("picture");
            ros.RegisterPublisher<PictureMsg>("picture");
            Assert.AreEqual(
                new[] { "open /goal workshop/msg/Waypoint latched 10", "open /picture workshop/msg/Picture large 10" },
                _bridge.Calls.ToArray());
        }

        [Test]
        public void Subscribe_ByAScriptOfTheConnector_GetsEachMessage()
        {
            var follower = new GameObject("follower").AddComponent<WaypointFollower>();
            follower.marker = new GameObject("marker");
            follower.Send("Start");
            Assert.AreEqual("subscribe /waypoint workshop/msg/Waypoint  10", _bridge.Calls[0]);
            Add(Payload("goal", 4, 5, 6));
            _streamer.Send("Update");
            Assert.AreEqual(4, follower.marker.transform.position.x);
            Assert.AreEqual(6, follower.marker.transform.position.z);
        }

        [Test]
        public void GetOrCreateInstance_SceneWithAStreamer_UsesIt()
        {
            ROSConnection first = ROSConnection.GetOrCreateInstance();
            Assert.AreSame(_streamer, first.GetComponent<Ml2SensorStreamer>());
            Assert.AreSame(first, ROSConnection.GetOrCreateInstance());
        }

        [Test]
        public void GetOrCreateInstance_AfterItsSceneAndWithoutAStreamer_MakesBoth()
        {
            ROSConnection first = ROSConnection.GetOrCreateInstance();
            GameObject.UnloadAll();
            ROSConnection second = ROSConnection.GetOrCreateInstance();
            Assert.AreNotSame(first, second);
            Assert.IsNotNull(second.GetComponent<Ml2SensorStreamer>());
        }

        [Test]
        public void Subscribe_TwoFunctions_ShareOneSubscriptionUntilUnsubscribe()
        {
            ROSConnection ros = ROSConnection.GetOrCreateInstance();
            var found = new List<string>();
            ros.Subscribe<WaypointMsg>("/waypoint", message => found.Add("a " + message.name));
            ros.Subscribe<WaypointMsg>("waypoint", message =>
            {
                found.Add("b " + message.name);
                ros.Unsubscribe("waypoint");
            });
            Add(Payload("1", 0, 0, 0));
            Add(Payload("2", 0, 0, 0));
            _streamer.Send("Update");
            Assert.AreEqual(new[] { "a 1", "b 1" }, found.ToArray());
            Assert.AreEqual(1, _bridge.Calls.Count(call => call.StartsWith("subscribe")));
            Assert.AreEqual("unsubscribe", _bridge.Calls.Last());
            Assert.IsFalse(ros.HasSubscriber("waypoint"));
        }

        [Test]
        public void Update_MalformedMessageOrFunctionThatThrows_IsLoggedAndTheNextOneComes()
        {
            ROSConnection ros = ROSConnection.GetOrCreateInstance();
            var found = new List<string>();
            ros.Subscribe<WaypointMsg>("waypoint", message => throw new ArithmeticException());
            ros.Subscribe<WaypointMsg>("waypoint", message => found.Add(message.name));
            byte[] whole = Payload("long enough that a shorter one would end in it", 1, 2, 3);
            Add(whole);
            for (int i = 0; i < 9; i++) Add(whole.Take(1 + i * whole.Length / 9).ToArray());
            _streamer.Send("Update");
            Assert.AreEqual(new[] { "ArithmeticException" }.Concat(Enumerable.Repeat("FormatException", 9)).ToArray(), Logged());
            whole[1] = 0; // Big-endian
            Add(whole);
            Add(Payload("last", 0, 0, 0));
            _streamer.Send("Update");
            Assert.AreEqual("last", found.Last());
            Assert.AreEqual(new[] { "FormatException", "ArithmeticException" }, Logged().Skip(10).ToArray());
        }

        [Test]
        public void Update_RefusedTopics_AreLoggedOnceEach()
        {
            ROSConnection ros = ROSConnection.GetOrCreateInstance();
            ros.Subscribe<WaypointMsg>("in", message => { });
            RosTopicState published = ros.RegisterPublisher<WaypointMsg>("out");
            for (int second = 0; second < 3; second++)
            {
                Time.realtimeSinceStartup += 2;
                ros.Send("Update");
            }
            Assert.AreEqual(new[] { "/in: no such topic", "/out: no such type" }, Debug.Warnings.ToArray());
            Assert.AreEqual("no such type", published.Refusal);
        }

        [Test]
        public void Publish_WithoutAHeadset_SendsNothing()
        {
            _streamer.OpenBridge = changed => _bridge = new ScriptedBridge(changed) { Unavailable = "no headset" };
            ROSConnection ros = ROSConnection.GetOrCreateInstance();
            ros.RegisterPublisher<WaypointMsg>("waypoint");
            ros.Publish("waypoint", new WaypointMsg());
            Assert.AreEqual(new[] { "open /waypoint workshop/msg/Waypoint 10" }, _bridge.Calls.ToArray());
        }

        [Test]
        public void Misuse_Throws()
        {
            ROSConnection ros = ROSConnection.GetOrCreateInstance();
            ros.RegisterPublisher<WaypointMsg>("waypoint");
            Throws<ArgumentException>("Expected workshop/Waypoint on /waypoint, found workshop/Other.", () => ros.Publish("waypoint", new OtherMsg()));
            Throws<InvalidOperationException>("RegisterPublisher<OtherMsg>(\"other\")", () => ros.Publish("other", new OtherMsg()));
            Throws<InvalidOperationException>("OtherMsg, which is not registered", () => ros.Subscribe<OtherMsg>("other", message => { }));
            Throws<InvalidOperationException>("Expected workshop/Waypoint on /waypoint", () => ros.RegisterPublisher("waypoint", "workshop/Other"));
            Throws<InvalidOperationException>("such as std_msgs/String, found workshop/msg/Other", () => ros.RegisterPublisher("other", "workshop/msg/Other"));
            Throws<ArgumentException>("Expected a request of workshop/Plan on /plan, found workshop/Other", () => Services().SendServiceMessage<WaypointMsg>("plan", new OtherMsg()));
        }

        /// <summary>Each is refused where it is registered, with the way out.</summary>
        [Test]
        public void Services_OfClassesThatAreNotRegistered_SayWhatToDo()
        {
            ROSConnection ros = Services();
            _bridge = null;
            foreach (TestDelegate use in new TestDelegate[]
            {
                () => ros.RegisterRosService<OtherMsg, WaypointMsg>("plan"),
                () => ros.RegisterRosService<PlanMsg, OtherMsg>("plan"),
                () => ros.SendServiceMessage<OtherMsg>("plan", new PlanMsg(), response => { }),
                () => ros.ImplementService<OtherMsg, WaypointMsg>("plan", request => new WaypointMsg()),
                () => ros.ImplementService<WaypointMsg, OtherMsg>("plan", request => new OtherMsg()),
            })
                Throws<InvalidOperationException>("Robotics > Generate ROS Messages", use);
            Throws<InvalidOperationException>(
                "Expected request and response of one service, found RosMessageTypes.Workshop.PlanMsg of workshop/Plan and RosMessageTypes.Workshop.PictureMsg of workshop/Picture",
                () => ros.RegisterRosService<PlanMsg, PictureMsg>("plan"));
            MessageRegistry.Register("Plan", WaypointMsg.Deserialize);
            Throws<InvalidOperationException>("such as std_srvs/SetBool, found Plan", () => ros.ImplementService<WaypointMsg, WaypointMsg>("plan", it => it));
            Assert.IsNull(_bridge);
        }

        [Test]
        public void SendServiceMessage_Response_ReachesFunctionAndTask()
        {
            ROSConnection ros = Services();
            ros.RegisterRosService<PlanMsg, WaypointMsg>("plan");
            var found = new List<string>();
            ros.SendServiceMessage<WaypointMsg>("/plan", new PlanMsg(), response => found.Add(response.name));
            Task<WaypointMsg> task = ros.SendServiceMessage<WaypointMsg>("plan", new PlanMsg());
            Assert.AreEqual(new[] { "call /plan workshop/srv/Plan" }, _bridge.Calls.ToArray());
            Assert.AreEqual(new byte[] { 0, 1, 0, 0, 0 }, _bridge.Services[0].Take(out long timeoutNanos));
            Assert.AreEqual(60000000000, timeoutNanos);
            for (uint number = 1; number <= 2; number++)
            {
                byte[] payload = Payload("goal " + number, 1, 2, 3);
                _bridge.Services[1].Add(payload, payload.Length, number);
            }
            _streamer.Send("Update");
            Assert.AreEqual(new[] { "goal 1" }, found.ToArray());
            Assert.AreEqual("goal 2", task.Result.name);
        }

        [Test]
        public void SendServiceMessage_Failure_IsLoggedAndEndsTheTask()
        {
            ROSConnection ros = Services();
            ros.SendServiceMessage<WaypointMsg>("plan", new PlanMsg(), response => Assert.Fail());
            Task<WaypointMsg> malformed = ros.SendServiceMessage<WaypointMsg>("plan", new PlanMsg());
            ros.SendServiceMessage<WaypointMsg>("plan", new PlanMsg(), response => throw new ArithmeticException());
            byte[] whole = Payload("goal", 1, 2, 3);
            _bridge.Services[1].Add(new[] { (byte)ServiceFailure.Unavailable, (byte)'n', (byte)'o' }, 3, 1);
            _bridge.Services[1].Add(whole, 9, 2);
            _bridge.Services[1].Add(whole, whole.Length, 3);
            _streamer.Send("Update");
            Assert.AreEqual("/plan: Unavailable: no", Debug.Warnings[0]);
            var failure = (ServiceFailedException)malformed.Exception.InnerException;
            Assert.AreEqual(ServiceFailure.Malformed, failure.Failure);
            StringAssert.Contains("Expected a response of workshop/Plan", failure.Message);
            Assert.AreEqual(new[] { "ArithmeticException" }, Logged());
            Throws<InvalidOperationException>("Expected workshop/Plan on /plan", () => ros.SendServiceMessage<PictureMsg>("plan", new PlanMsg()));
        }

        [Test]
        public void ImplementService_Requests_AreAnsweredByTheFunctionOrFail()
        {
            ROSConnection ros = Services();
            var later = new TaskCompletionSource<WaypointMsg>();
            ros.ImplementService<WaypointMsg, WaypointMsg>("plan", request =>
            {
                if (request.name == "no") throw new ArithmeticException("no way");
                return new WaypointMsg { name = "to " + request.name };
            });
            ros.ImplementService<WaypointMsg, WaypointMsg>("later", request => later.Task);
            Assert.AreEqual("offer /plan workshop/srv/Plan", _bridge.Calls[0]);
            NativeInbox responses = _bridge.Services[0], laterResponses = _bridge.Services[2];
            byte[] good = Payload("goal", 0, 0, 0), bad = Payload("no", 0, 0, 0);
            _bridge.Services[1].Add(good, good.Length, 5);
            _bridge.Services[1].Add(bad, bad.Length, 6);
            _bridge.Services[1].Add(good, 7, 7);
            _bridge.Services[3].Add(good, good.Length, 8);
            _streamer.Send("Update");
            Assert.AreEqual(Payload("to goal", 0, 0, 0), responses.Take());
            Assert.AreEqual(5, responses.LastNumber);
            Assert.AreEqual("\u0001ArithmeticException: no way", System.Text.Encoding.UTF8.GetString(responses.Take()));
            Assert.AreEqual(6, responses.LastNumber);
            StringAssert.StartsWith("\u0001FormatException", System.Text.Encoding.UTF8.GetString(responses.Take()));
            Assert.AreEqual(new[] { "ArithmeticException", "FormatException" }, Logged());
            Assert.IsNull(laterResponses.Take());
            later.SetResult(new WaypointMsg { name = "much later" });
            Assert.AreEqual(Payload("much later", 0, 0, 0), laterResponses.Take());
            Throws<InvalidOperationException>("one ImplementService for /plan", () => ros.ImplementService<WaypointMsg, WaypointMsg>("/plan", it => it));
            Time.realtimeSinceStartup += 2;
            ros.Send("Update");
            Assert.AreEqual(new[] { "/later: no rule", "/plan: no rule" }, Debug.Warnings.OrderBy(it => it).ToArray());
            ros.Send("OnDestroy");
            Assert.AreEqual(2, _bridge.Calls.Count(it => it == "close service"));
        }

        private static ROSConnection Services()
        {
            MessageRegistry.Register("workshop/Plan", WaypointMsg.Deserialize, MessageSubtopic.Response); // And of requests
            MessageRegistry.Register("workshop/Plan", _ => new PlanMsg());
            MessageRegistry.Register("workshop/Picture", _ => new PictureMsg());
            return ROSConnection.GetOrCreateInstance();
        }

        private void Connect()
        {
            _bridge.RaiseStatus("{'state': 'connected', 'receiver': 'desk'}");
            _streamer.Send("Update");
        }

        private static void Throws<T>(string message, TestDelegate call) where T : Exception =>
            StringAssert.Contains(message, Assert.Throws<T>(call).Message);

        private static string[] Logged() => Debug.Exceptions.Select(e => e.GetType().Name).ToArray();

        /// <summary>The payload by the package's own writer.</summary>
        private static byte[] Payload(string name, double x, double y, double z)
        {
            var cdr = new CdrWriter();
            cdr.WritePayload(new Waypoint { Name = name, Values = new[] { x, y, z } });
            return cdr.Buffer.Take(cdr.Length).ToArray();
        }

        private void Add(byte[] payload) => _bridge.Inboxes.Last().Add(payload, payload.Length);

        private sealed class Waypoint : IMessage
        {
            public string Name;
            public double[] Values;

            public string RosType => "workshop/msg/Waypoint";

            public void Write(CdrWriter cdr)
            {
                cdr.Write(Name);
                foreach (double value in Values) cdr.Write(value);
            }
        }
    }
}
