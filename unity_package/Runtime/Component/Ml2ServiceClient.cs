using System;
using System.Collections.Generic;
using System.Text;
using System.Threading;
using System.Threading.Tasks;
using Ml2Sensors.Messages;

namespace Ml2Sensors
{
    /// <summary>The reason why a call of a service has no response. The library has the same numbers.</summary>
    public enum ServiceFailure
    {
        /// <summary>It has a response.</summary>
        None,

        /// <summary>No node offers the service, or its node is gone.</summary>
        Unavailable,

        /// <summary>The response did not come in time. The service may have done what it was asked to do.</summary>
        Timeout,

        /// <summary>The receiver does not let the app call the service, or the client is disposed.</summary>
        Refused,

        /// <summary>The receiver or the app cannot read the other's bytes.</summary>
        Malformed,

        /// <summary>The request, or the response, has more than 64 KiB.</summary>
        TooLarge,

        /// <summary>Too many calls are under way: 16 of a client, or 64 of the app.</summary>
        Busy,

        /// <summary>There was no session, or it was lost before the response. The service may have done what it was asked to do.</summary>
        LinkDown,

        /// <summary>Any other reason, which the text says.</summary>
        Other,
    }

    /// <summary>The outcome of a call: a response, or a failure.</summary>
    public readonly struct ServiceResult<T> where T : class
    {
        internal ServiceResult(T response, ServiceFailure failure, string reason)
        {
            Response = response;
            Failure = failure;
            Reason = reason;
        }

        /// <summary>The response; null after a failure.</summary>
        public T Response { get; }

        /// <summary>None if there is a response.</summary>
        public ServiceFailure Failure { get; }

        /// <summary>The reason of a failure, for people; else empty.</summary>
        public string Reason { get; }
    }

    /// <summary>
    /// Calls a service of ROS, over starts and stops of the streamer, until Dispose. The receiver's user has to allow the
    /// service (app.call). Use it on the main thread.
    /// </summary>
    public sealed class Ml2ServiceClient<TRequest, TResponse> : IDisposable
        where TRequest : class, IMessage, new() where TResponse : class, IReadable, new()
    {
        private const string RequestSuffix = "_Request", ResponseSuffix = "_Response";
        private const float MostSeconds = 1e6f;
        private readonly CdrWriter _writer = new CdrWriter();
        private readonly CdrReader _reader = new CdrReader();
        private readonly ServiceCalls _calls;

        /// <param name="service">The name in ROS, such as "/pause".</param>
        /// <exception cref="ArgumentException">The classes are not those of one service, as ml2-receiver messages writes them.</exception>
        public Ml2ServiceClient(Ml2SensorStreamer streamer, string service)
        {
            string request = new TRequest().RosType, response = new TResponse().RosType;
            string type = request.EndsWith(RequestSuffix) ? request.Substring(0, request.Length - RequestSuffix.Length) : "";
            if (type == "" || response != type + ResponseSuffix)
                throw new ArgumentException($"Expected request and response of one service, found {request} and {response}.");
            _calls = new ServiceCalls(streamer, service, type);
        }

        /// <summary>
        /// Calls the service. The task ends in Update of the streamer, with the response or a failure. Without a session the
        /// call waits for one, as long as its time-out is.
        /// </summary>
        /// <param name="timeout">In s.</param>
        /// <param name="token">Ends the wait: the task is cancelled. The service may do what it was asked to do.</param>
        /// <exception cref="ArgumentException">The time-out is not above 0, or the message cannot be written.</exception>
        public Task<ServiceResult<TResponse>> CallAsync(TRequest request, float timeout, CancellationToken token = default)
        {
            if (!(timeout > 0 && timeout <= MostSeconds)) throw new ArgumentException($"Expected more than 0, found {timeout}.", nameof(timeout));
            if (token.IsCancellationRequested) return Task.FromCanceled<ServiceResult<TResponse>>(token);
            _writer.WritePayload(request);
            var result = new TaskCompletionSource<ServiceResult<TResponse>>();
            CancellationTokenRegistration registration = token.Register(() => result.TrySetCanceled(token));
            _calls.Call(_writer.Buffer, _writer.Length, timeout, (payload, length, failure, reason) =>
            {
                registration.Dispose();
                result.TrySetResult(Result(payload, length, failure, reason));
            });
            return result.Task;
        }

        /// <summary>Ends the client. Calls that are under way end as Refused, and later ones too.</summary>
        public void Dispose() => _calls.Dispose();

        private ServiceResult<TResponse> Result(byte[] payload, int length, ServiceFailure failure, string reason)
        {
            if (failure != ServiceFailure.None) return new ServiceResult<TResponse>(null, failure, reason);
            var response = new TResponse();
            return _reader.TryReadPayload(payload, length, response)
                ? new ServiceResult<TResponse>(response, ServiceFailure.None, "")
                : new ServiceResult<TResponse>(null, ServiceFailure.Malformed, _reader.Error.ToString());
        }
    }

    /// <summary>
    /// A service that the app offers to ROS, whose requests and responses wait in native memory. Each request is answered
    /// once, by Respond or Fail, on any thread.
    /// </summary>
    internal sealed class ServiceOffer : IDisposable
    {
        private readonly Ml2SensorStreamer _streamer;
        private readonly uint _server;
        private readonly Outbox _responses;
        private readonly Inbox _requests;
        private bool _isDisposed;

        /// <param name="answer">Called with a request at the start of an array that is used again, and with its number.</param>
        public ServiceOffer(Ml2SensorStreamer streamer, string service, string rosType, Action<byte[], int, uint> answer)
        {
            _streamer = streamer;
            _server = streamer.Bridge.OfferService(service, rosType);
            _responses = new Outbox(streamer, _server);
            _requests = Inbox.Of(streamer, streamer.Bridge.ServiceInbox(_server), (bytes, length) => answer(bytes, length, _requests.MessageNumber), null);
        }

        public string Refusal => _streamer.Bridge.ServiceRefusal(_server);

        public void Respond(uint number, byte[] payload)
        {
            string wrong = _responses.Wrong(payload, payload.Length);
            if (wrong != null) Fail(number, wrong);
            else _responses.Put(payload, payload.Length, 0, number);
        }

        /// <param name="reason">For the caller.</param>
        public void Fail(uint number, string reason)
        {
            byte[] bytes = Encoding.UTF8.GetBytes("\u0001" + reason);
            _responses.Put(bytes, bytes.Length, 0, number);
        }

        public void Dispose()
        {
            if (_isDisposed) return;
            _isDisposed = true;
            _requests.Dispose();
            _streamer.Bridge.CloseService(_server);
        }
    }

    /// <summary>The calls of one service, whose requests and responses wait in native memory. Each ends once.</summary>
    internal sealed class ServiceCalls : IDisposable
    {
        /// <summary>As many as may wait in an outbox and an inbox without being replaced, and more than a receiver takes.</summary>
        private const int MostCalls = 64;

        private readonly Dictionary<uint, Done> _underWay = new Dictionary<uint, Done>();
        private readonly Ml2SensorStreamer _streamer;
        private readonly uint _client;
        private readonly Outbox _requests;
        private readonly Inbox _responses;
        private string _ended;
        private uint _last;

        public ServiceCalls(Ml2SensorStreamer streamer, string service, string rosType)
        {
            _streamer = streamer;
            _client = streamer.Bridge.CallService(service, rosType);
            _requests = new Outbox(streamer, _client);
            _responses = Inbox.Of(streamer, streamer.Bridge.ServiceInbox(_client), Read, () => End(ServiceFailure.LinkDown, "the streamer is destroyed"));
        }

        /// <param name="payload">The response at its start; used again after the call. Null after a failure.</param>
        public delegate void Done(byte[] payload, int length, ServiceFailure failure, string reason);

        /// <param name="done">Called once, on the main thread; at once if the request cannot be sent.</param>
        public void Call(byte[] payload, int length, float timeout, Done done)
        {
            const double NanosPerSecond = 1e9;
            string wrong = _requests.Wrong(payload, length);
            if (_ended != null) done(null, 0, ServiceFailure.Refused, _ended);
            else if (wrong != null) done(null, 0, length > Outbox.SmallBytes ? ServiceFailure.TooLarge : ServiceFailure.Malformed, wrong);
            else if (_underWay.Count == MostCalls) done(null, 0, ServiceFailure.Busy, $"{MostCalls} calls are under way");
            else if (!_requests.Put(payload, length, Math.Max(1, (long)(timeout * NanosPerSecond)), ++_last))
                done(null, 0, ServiceFailure.LinkDown, _streamer.Unavailable ?? "there is no memory");
            else _underWay[_last] = done;
        }

        public void Dispose()
        {
            if (_ended == null) _streamer.Bridge.CloseService(_client);
            End(ServiceFailure.Refused, "the client is disposed");
        }

        private void End(ServiceFailure failure, string reason)
        {
            if (_ended != null) return;
            _ended = reason;
            _responses.Dispose();
            var ended = new List<Done>(_underWay.Values);
            _underWay.Clear();
            foreach (Done done in ended) done(null, 0, failure, reason);
        }

        private void Read(byte[] bytes, int length)
        {
            if (!_underWay.TryGetValue(_responses.MessageNumber, out Done done)) return;
            _underWay.Remove(_responses.MessageNumber);
            if (bytes[0] == 0) done(bytes, length, ServiceFailure.None, "");
            else done(null, 0, (ServiceFailure)bytes[0], Encoding.UTF8.GetString(bytes, 1, length - 1));
        }
    }
}
