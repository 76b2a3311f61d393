using System;
using System.Threading.Tasks;
using Ml2Sensors.Interop;
using Unity.Robotics.ROSTCPConnector.MessageGeneration;
using UnityEngine;

namespace Ml2Sensors.RosTcp
{
    /// <summary>A topic of the ROSConnection.</summary>
    public sealed class RosTopicState
    {
        /// <summary>As many as ROS-TCP-Endpoint lets wait.</summary>
        private const int Depth = 10;

        private readonly Ml2SensorStreamer _streamer;
        private readonly string _rosType;
        private Outbox _outbox;
        private Inbox _inbox;
        private Func<MessageDeserializer, Message> _deserialize;
        private Action<Message>[] _callbacks = new Action<Message>[0];
        private readonly RefusalLog _log = new RefusalLog();

        internal RosTopicState(Ml2SensorStreamer streamer, string topic, string rosMessageName)
        {
            _streamer = streamer;
            Topic = topic;
            RosMessageName = rosMessageName;
            _rosType = Payload.RosType(rosMessageName, "msg");
        }

        /// <summary>The name in ROS, which begins with "/".</summary>
        public string Topic { get; }

        /// <summary>The type as the connector writes it, such as "std_msgs/String".</summary>
        public string RosMessageName { get; }

        /// <summary>True after RegisterPublisher.</summary>
        public bool IsPublisher => _outbox != null;

        /// <summary>True from Subscribe to Unsubscribe.</summary>
        public bool HasSubscriberCallback => _callbacks.Length > 0;

        /// <summary>The reasons why the receiver does not serve the topic; empty if it does. Not for each frame: it calls Java.</summary>
        public string Refusal
        {
            get
            {
                string publishing = _outbox?.Refusal ?? "";
                string subscribing = _inbox?.Refusal ?? "";
                return publishing == "" || subscribing == "" ? publishing + subscribing : $"{publishing}; {subscribing}";
            }
        }

        /// <summary>Does what ROSConnection.Publish does.</summary>
        public void Publish(Message message)
        {
            if (message.RosMessageName != RosMessageName)
                throw new ArgumentException($"Expected {RosMessageName} on {Topic}, found {message.RosMessageName}.", nameof(message));
            if (_streamer.Unavailable != null) return;
            byte[] payload = Payload.Of(message);
            _outbox.Add(payload, payload.Length, NativeMethods.Now());
        }

        internal void RegisterPublisher(bool isLatched, bool isLarge)
        {
            if (_outbox == null) _outbox = new Outbox(_streamer, Topic, _rosType, isLatched, isLarge, false, Depth);
        }

        internal void Subscribe(Func<MessageDeserializer, Message> deserialize, Action<Message> callback)
        {
            _deserialize = deserialize;
            Array.Resize(ref _callbacks, _callbacks.Length + 1); // A new one: the old one may be under way
            _callbacks[_callbacks.Length - 1] = callback;
            if (_inbox == null) _inbox = Inbox.Subscribe(_streamer, Topic, _rosType, "", Depth, 0, Read);
        }

        internal void Unsubscribe()
        {
            _callbacks = new Action<Message>[0];
            _inbox?.Dispose();
            _inbox = null;
        }

        internal void LogRefusal() => _log.Log(Topic, Refusal);

        private void Read(byte[] bytes, int length)
        {
            Message message;
            try
            {
                message = Payload.Read(bytes, length, _deserialize);
            }
            catch (FormatException e)
            {
                Debug.LogException(new FormatException($"Expected {RosMessageName} on {Topic}. {e.Message}", e));
                return;
            }
            foreach (Action<Message> callback in _callbacks)
            {
                try
                {
                    callback(message);
                }
                catch (Exception e) // A script's own
                {
                    Debug.LogException(e);
                }
            }
        }
    }

    /// <summary>Logs each reason once.</summary>
    internal sealed class RefusalLog
    {
        private string _logged = "";

        public void Log(string name, string reason)
        {
            if (reason != "" && reason != _logged) Debug.LogWarning($"{name}: {reason}");
            _logged = reason;
        }
    }

    /// <summary>A call of a service has failed.</summary>
    public sealed class ServiceFailedException : Exception
    {
        internal ServiceFailedException(ServiceFailure failure, string message) : base(message) => Failure = failure;

        /// <summary>The reason as a value.</summary>
        public ServiceFailure Failure { get; }
    }

    /// <summary>A service that the ROSConnection calls.</summary>
    internal sealed class RosService : IDisposable
    {
        private const float TimeoutSeconds = 60;
        private readonly string _name;
        private readonly ServiceCalls _calls;

        public RosService(Ml2SensorStreamer streamer, string name, string rosServiceName)
        {
            _name = name;
            RosServiceName = rosServiceName;
            _calls = new ServiceCalls(streamer, name, Payload.RosType(rosServiceName, "srv"));
        }

        /// <summary>The type as the connector writes it, such as "std_srvs/SetBool".</summary>
        public string RosServiceName { get; }

        /// <summary>Calls one of both functions. Logs failures, since scripts of the connector do not ask.</summary>
        public void Call<TResponse>(Message request, Action<TResponse> done, Action<ServiceFailedException> failed) where TResponse : Message
        {
            if (request.RosMessageName != RosServiceName)
                throw new ArgumentException($"Expected a request of {RosServiceName} on {_name}, found {request.RosMessageName}.", nameof(request));
            byte[] payload = Payload.Of(request);
            _calls.Call(payload, payload.Length, TimeoutSeconds, (bytes, length, failure, reason) =>
            {
                TResponse response = null;
                if (failure == ServiceFailure.None)
                    try
                    {
                        response = (TResponse)Payload.Read(bytes, length, MessageRegistry.GetDeserializeFunction<TResponse>());
                    }
                    catch (FormatException e)
                    {
                        failure = ServiceFailure.Malformed;
                        reason = $"Expected a response of {RosServiceName}. {e.Message}";
                    }
                try
                {
                    if (response != null) done(response);
                    else Fail(failure, reason, failed);
                }
                catch (Exception e) // A script's own
                {
                    Debug.LogException(e);
                }
            });
        }

        public void Dispose() => _calls.Dispose();

        private void Fail(ServiceFailure failure, string reason, Action<ServiceFailedException> failed)
        {
            Debug.LogWarning($"{_name}: {failure}: {reason}");
            failed(new ServiceFailedException(failure, $"{_name}: {reason}"));
        }
    }

    /// <summary>A service that the ROSConnection offers.</summary>
    internal sealed class RosOffer : IDisposable
    {
        private readonly RefusalLog _log = new RefusalLog();
        private readonly string _name;
        private readonly Func<MessageDeserializer, Message> _deserialize;
        private readonly Func<Message, Task<Message>> _answer;
        private readonly ServiceOffer _offer;

        public RosOffer(
            Ml2SensorStreamer streamer, string name, string rosServiceName, Func<MessageDeserializer, Message> deserialize, Func<Message, Task<Message>> answer)
        {
            _name = name;
            _deserialize = deserialize;
            _answer = answer;
            _offer = new ServiceOffer(streamer, name, Payload.RosType(rosServiceName, "srv"), Answer);
        }

        public void LogRefusal() => _log.Log(_name, _offer.Refusal);

        public void Dispose() => _offer.Dispose();

        private async void Answer(byte[] bytes, int length, uint number)
        {
            try
            {
                Message request = Payload.Read(bytes, length, _deserialize);
                _offer.Respond(number, Payload.Of(await _answer(request)));
            }
            catch (Exception e) // A script's own, or a malformed request
            {
                Debug.LogException(e);
                _offer.Fail(number, $"{e.GetType().Name}: {e.Message}");
            }
        }
    }

    /// <summary>Messages of the connector as CDR, after 00 01 00 00.</summary>
    internal static class Payload
    {
        private static readonly MessageSerializer Serializer = new MessageSerializer();
        private static readonly MessageDeserializer Deserializer = new MessageDeserializer();

        /// <summary>Returns the name of a type in ROS 2.</summary>
        /// <exception cref="InvalidOperationException">The connector does not name types so.</exception>
        public static string RosType(string name, string kind)
        {
            string[] parts = name.Split('/');
            return parts.Length == 2 ? $"{parts[0]}/{kind}/{parts[1]}" : throw new InvalidOperationException(
                $"Expected a type such as {(kind == "srv" ? "std_srvs/SetBool" : "std_msgs/String")}, found {name}.");
        }

        public static byte[] Of(Message message)
        {
            Serializer.Clear();
            Serializer.SerializeMessage(message);
            byte[] payload = Serializer.GetBytes();
            if (payload.Length == 4) Array.Resize(ref payload, 5); // ROS 2 has a byte for a message without fields
            return payload;
        }

        /// <summary>Copies the bytes, because their deserializer does not know where a message ends in a longer array.</summary>
        /// <exception cref="FormatException">The bytes are no such message.</exception>
        public static Message Read(byte[] bytes, int length, Func<MessageDeserializer, Message> deserialize)
        {
            if (length < 4 || bytes[0] != 0 || bytes[1] != 1) throw new FormatException("Expected a payload that begins with 00 01.");
            var payload = new byte[length];
            Buffer.BlockCopy(bytes, 0, payload, 0, length);
            Deserializer.InitWithBuffer(payload);
            try
            {
                return deserialize(Deserializer);
            }
            catch (Exception e) // Theirs throws any
            {
                throw new FormatException($"Found {length} bytes that are none.", e);
            }
        }
    }
}
