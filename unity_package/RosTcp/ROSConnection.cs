using System;
using System.Collections.Generic;
using System.Threading.Tasks;
using Unity.Robotics.ROSTCPConnector.MessageGeneration;
using UnityEngine;

namespace Ml2Sensors.RosTcp
{
    /// <summary>
    /// Publishes, subscribes, calls and offers services with the members and message classes of ROS-TCP-Connector, through the session
    /// of the streamer. A script changes its using alone. Use it on the main thread.
    /// </summary>
    [AddComponentMenu("ML2 Sensors/ROS Connection")]
    [DisallowMultipleComponent]
    [RequireComponent(typeof(Ml2SensorStreamer))]
    public sealed class ROSConnection : MonoBehaviour
    {
        private const float SecondsBetweenLooks = 1;
        private static ROSConnection _instance;

        private readonly Dictionary<string, RosTopicState> _topics = new Dictionary<string, RosTopicState>();
        private readonly Dictionary<string, RosService> _services = new Dictionary<string, RosService>();
        private readonly Dictionary<string, RosOffer> _offers = new Dictionary<string, RosOffer>();
        private Ml2SensorStreamer _streamer;
        private float _nextLookSeconds;

        /// <summary>The same as GetOrCreateInstance().</summary>
        public static ROSConnection instance => GetOrCreateInstance();

        /// <summary>True while no session runs.</summary>
        public bool HasConnectionError => Streamer.Status.State != ConnectionState.Connected;

        private Ml2SensorStreamer Streamer => _streamer != null ? _streamer : _streamer = GetComponent<Ml2SensorStreamer>();

        /// <summary>
        /// Returns the ROSConnection of the scene. If there is none, adds one to the object of the streamer, or to a new
        /// object with a streamer.
        /// </summary>
        public static ROSConnection GetOrCreateInstance()
        {
            if (_instance != null) return _instance;
            _instance = FindFirstObjectByType<ROSConnection>();
            if (_instance != null) return _instance;
            var streamer = FindFirstObjectByType<Ml2SensorStreamer>();
            GameObject owner = streamer != null ? streamer.gameObject : new GameObject("ROSConnection");
            return _instance = owner.AddComponent<ROSConnection>();
        }

        /// <summary>Starts the streamer, which finds the receiver by itself. Has no effect if it was started.</summary>
        public void Connect() => Streamer.StartStreaming();

        /// <summary>Stops the streamer, with its sensors.</summary>
        public void Disconnect() => Streamer.StopStreaming();

        /// <summary>Prepares to publish a topic. The receiver's user has to allow it (custom.enabled and app.publish).</summary>
        /// <param name="rosTopicName">The name in ROS; a "/" is put in front of it if it has none.</param>
        /// <param name="queue_size">Without effect: the receiver sets the quality of service.</param>
        /// <param name="latch">True keeps the newest message for late subscribers.</param>
        /// <exception cref="InvalidOperationException">The topic has another type, or the class has no ROS name.</exception>
        public RosTopicState RegisterPublisher<T>(string rosTopicName, int? queue_size = null, bool? latch = null) where T : Message =>
            RegisterPublisher(rosTopicName, NameOf<T>(), latch, HasBytes(typeof(T)));

        /// <summary>
        /// Does the same for a class that is known by its ROS name, such as "std_msgs/String". Its messages have at most 64 KiB.
        /// </summary>
        public RosTopicState RegisterPublisher(string rosTopicName, string rosMessageName, int? queueSize = null, bool? latch = null) =>
            RegisterPublisher(rosTopicName, rosMessageName, latch, false);

        /// <summary>Sends a message as it is; nothing is sent while no receiver takes the topic.</summary>
        /// <exception cref="InvalidOperationException">RegisterPublisher was not called for the topic.</exception>
        /// <exception cref="ArgumentException">The message has another type, or is too large.</exception>
        public void Publish(string rosTopicName, Message message)
        {
            if (!_topics.TryGetValue(Absolute(rosTopicName), out RosTopicState topic) || !topic.IsPublisher)
                throw new InvalidOperationException($"Expected RegisterPublisher<{message.GetType().Name}>(\"{rosTopicName}\") before Publish, found none.");
            topic.Publish(message);
        }

        /// <summary>
        /// Calls a function in Update of the streamer for each message of a topic. The receiver's user has to allow the topic
        /// (app.subscribe). An exception of the function is logged, and the next message comes.
        /// </summary>
        /// <exception cref="InvalidOperationException">The topic has another type, or the class has no ROS name.</exception>
        public void Subscribe<T>(string topic, Action<T> callback) where T : Message =>
            Topic(topic, NameOf<T>()).Subscribe(MessageRegistry.GetDeserializeFunction<T>(), message => callback((T)message));

        /// <summary>Ends all subscriptions of a topic.</summary>
        public void Unsubscribe(string topic)
        {
            if (_topics.TryGetValue(Absolute(topic), out RosTopicState found)) found.Unsubscribe();
        }

        /// <summary>Returns true if Subscribe was called for the topic.</summary>
        public bool HasSubscriber(string topic) =>
            _topics.TryGetValue(Absolute(topic), out RosTopicState found) && found.HasSubscriberCallback;

        /// <summary>Prepares to call a service. The receiver's user has to allow it (app.call).</summary>
        /// <exception cref="InvalidOperationException">The service has another type, or the class has no ROS name.</exception>
        public void RegisterRosService<TRequest, TResponse>(string topic) where TRequest : Message where TResponse : Message =>
            Service(topic, NameOf<TRequest, TResponse>());

        /// <summary>
        /// Calls a service, also one that was not registered, and a function with the response in Update of the streamer. A
        /// failure is logged with its reason; the function is not called then. A call without a response fails after 60 s.
        /// </summary>
        /// <exception cref="InvalidOperationException">The service has another type, or the class has no ROS name.</exception>
        /// <exception cref="ArgumentException">The request is of another service.</exception>
        public void SendServiceMessage<TResponse>(string rosServiceName, Message serviceRequest, Action<TResponse> callback)
            where TResponse : Message, new() =>
            Service(rosServiceName, NameOf<TResponse>()).Call(serviceRequest, callback, failure => { });

        /// <summary>Does the same for a task, which a failure ends with a ServiceFailedException.</summary>
        public Task<TResponse> SendServiceMessage<TResponse>(string rosServiceName, Message serviceRequest)
            where TResponse : Message, new()
        {
            var response = new TaskCompletionSource<TResponse>();
            Service(rosServiceName, NameOf<TResponse>()).Call<TResponse>(serviceRequest, response.SetResult, response.SetException);
            return response.Task;
        }

        /// <summary>
        /// Offers a service, whose requests a function answers in Update of the streamer. The receiver's user has to allow it
        /// (app.offer). An exception of the function is logged, and fails the call.
        /// </summary>
        /// <param name="queueSize">Without effect: at most 16 requests of a service are under way, and others fail.</param>
        /// <exception cref="InvalidOperationException">The service is offered already, or a class has no ROS name.</exception>
        public void ImplementService<TRequest, TResponse>(string topic, Func<TRequest, TResponse> callback, int? queueSize = null)
            where TRequest : Message where TResponse : Message =>
            ImplementService<TRequest, TResponse>(topic, request => Task.FromResult(callback(request)), queueSize);

        /// <summary>Does the same by a function whose task ends with the response.</summary>
        public void ImplementService<TRequest, TResponse>(string topic, Func<TRequest, Task<TResponse>> callback, int? queueSize = null)
            where TRequest : Message where TResponse : Message
        {
            string name = Absolute(topic);
            if (_offers.ContainsKey(name)) throw new InvalidOperationException($"Expected one ImplementService for {name}, found another.");
            _offers[name] = new RosOffer(
                Streamer, name, NameOf<TRequest, TResponse>(), MessageRegistry.GetDeserializeFunction<TRequest>(), async request => await callback((TRequest)request));
        }

        /// <summary>Returns true for messages that may be large, such as images: those with a sequence of bytes.</summary>
        private static bool HasBytes(Type type) =>
            Array.Exists(type.GetFields(), it => it.FieldType == typeof(byte[]) || it.FieldType == typeof(sbyte[]));

        private static string NameOf<T>() where T : Message =>
            MessageRegistry.GetRosMessageName<T>() ?? throw new InvalidOperationException(
                $"Expected a message class with a name in ROS, found {typeof(T)}, which is not registered. Generate it with " +
                "ROS-TCP-Connector 0.7 or later (Robotics > Generate ROS Messages), and use it from Start on, not in Awake.");

        private static string NameOf<TRequest, TResponse>() where TRequest : Message where TResponse : Message
        {
            string request = NameOf<TRequest>(), response = NameOf<TResponse>();
            return request == response ? response : throw new InvalidOperationException(
                $"Expected request and response of one service, found {typeof(TRequest)} of {request} and {typeof(TResponse)} of {response}.");
        }

        /// <summary>Resolves a name as ROS-TCP-Endpoint does, which has no namespace.</summary>
        private static string Absolute(string name) => name.StartsWith("/") ? name : "/" + name;

        private RosTopicState RegisterPublisher(string name, string rosMessageName, bool? isLatched, bool isLarge)
        {
            RosTopicState topic = Topic(name, rosMessageName);
            topic.RegisterPublisher(isLatched == true, isLarge);
            return topic;
        }

        private RosService Service(string name, string rosServiceName)
        {
            name = Absolute(name);
            if (!_services.TryGetValue(name, out RosService service))
                _services[name] = service = new RosService(Streamer, name, rosServiceName);
            if (service.RosServiceName != rosServiceName)
                throw new InvalidOperationException($"Expected {service.RosServiceName} on {name}, found {rosServiceName}.");
            return service;
        }

        private RosTopicState Topic(string name, string rosMessageName)
        {
            name = Absolute(name);
            if (!_topics.TryGetValue(name, out RosTopicState topic))
                _topics[name] = topic = new RosTopicState(Streamer, name, rosMessageName);
            if (topic.RosMessageName != rosMessageName)
                throw new InvalidOperationException($"Expected {topic.RosMessageName} on {name}, found {rosMessageName}.");
            return topic;
        }

        /// <summary>Logs why topics do not work, since scripts of the connector do not ask.</summary>
        private void Update()
        {
            if (Time.realtimeSinceStartup < _nextLookSeconds) return;
            _nextLookSeconds = Time.realtimeSinceStartup + SecondsBetweenLooks;
            foreach (RosTopicState topic in _topics.Values) topic.LogRefusal();
            foreach (RosOffer offer in _offers.Values) offer.LogRefusal();
        }

        private void OnDestroy()
        {
            foreach (RosTopicState topic in _topics.Values) topic.Unsubscribe();
            foreach (RosService service in _services.Values) service.Dispose();
            foreach (RosOffer offer in _offers.Values) offer.Dispose();
        }
    }
}
