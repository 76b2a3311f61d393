using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Runtime.InteropServices;
using Ml2Sensors.Interop;
using Ml2Sensors.Messages;

namespace Ml2Sensors
{
    /// <summary>
    /// Receives the messages of a ROS topic, over starts and stops of the streamer, until Dispose. The receiver's user has to
    /// allow the topic (app.subscribe). Use it on the main thread.
    /// </summary>
    public sealed class Ml2Subscriber<T> : IDisposable where T : class, IReadable, new()
    {
        private readonly CdrReader _cdr = new CdrReader();
        private readonly T _message = new T();
        private readonly Inbox _inbox;

        /// <param name="topic">The name in ROS, such as "/joint_states".</param>
        /// <param name="depth">
        /// How many messages may wait for a frame, 1 to 100. 1 is for what is shown, such as a pose: the newest alone. More
        /// is for what should not be skipped, such as events.
        /// </param>
        /// <param name="maxHz">The greatest rate at which the receiver sends messages; it leaves out others. 0 has no bound.</param>
        /// <exception cref="ArgumentException">The depth is not from 1 to 100, or the rate is below 0 or no number.</exception>
        public Ml2Subscriber(Ml2SensorStreamer streamer, string topic, int depth = 1, double maxHz = 0)
        {
            if (depth < 1 || depth > 100) throw new ArgumentException($"Expected 1 to 100, found {depth}.", nameof(depth));
            if (!(maxHz >= 0 && maxHz < double.PositiveInfinity)) throw new ArgumentException($"Expected 0 or more, found {maxHz}.", nameof(maxHz));
            _inbox = Inbox.Subscribe(streamer, topic, _message.RosType, _message.RosHash, depth, maxHz, Read);
        }

        /// <summary>
        /// Raised in the streamer's Update for each message, in their order. The message object is used again for the next
        /// one: copy what you keep.
        /// </summary>
        public event Action<T> Received;

        /// <summary>When the last message was published, in ROS time; 0 if unknown.</summary>
        public long PublishedNanos => _inbox.PublishedNanos;

        /// <summary>The number of messages that Received was raised for.</summary>
        public long Count { get; private set; }

        /// <summary>
        /// The number of messages that newer ones replaced: more came than may wait, or the frame had no time left.
        /// </summary>
        public long LeftOut => _inbox.LeftOut;

        /// <summary>The number of messages that were malformed, of which Error describes the last one.</summary>
        public long Malformed { get; private set; }

        /// <summary>Describes the last malformed message; null if there was none.</summary>
        public MalformedMessage Error { get; private set; }

        /// <summary>The reason why the receiver does not send the topic; empty if it does. Not for each frame: it calls Java.</summary>
        public string Refusal => _inbox.Refusal;

        /// <summary>Ends the subscription.</summary>
        public void Dispose() => _inbox.Dispose();

        private void Read(byte[] bytes, int length)
        {
            if (_cdr.TryReadPayload(bytes, length, _message))
            {
                Count++;
                Received?.Invoke(_message);
            }
            else
            {
                Malformed++;
                Error = _cdr.Error;
            }
        }
    }

    /// <summary>Messages that wait in native memory until a frame takes them.</summary>
    internal sealed class Inbox : IPumped, IDisposable
    {
        private readonly Ml2SensorStreamer _streamer;
        private readonly Action<byte[], int> _read;
        private readonly uint _number;
        private readonly bool _isTopic;
        private readonly Action _end;
        private byte[] _bytes = new byte[256];
        private bool _isDisposed;

        private Inbox(Ml2SensorStreamer streamer, uint number, bool isTopic, Action<byte[], int> read, Action end)
        {
            _streamer = streamer;
            _read = read;
            _number = number;
            _isTopic = isTopic;
            _end = end;
            if (_number != 0) NativeMethods.CheckVersion();
            streamer.Pump.Add(this);
        }

        public long PublishedNanos { get; private set; }

        /// <summary>The number of the message that is read.</summary>
        public uint MessageNumber { get; private set; }

        public long LeftOut { get; private set; }

        public string Refusal => _isDisposed ? "" : _streamer.Bridge.SubscriptionRefusal(_number);

        /// <param name="hash">The hash of the type, or empty.</param>
        /// <param name="read">Called for each message, with its payload at the start of an array that is used again.</param>
        public static Inbox Subscribe(
            Ml2SensorStreamer streamer, string topic, string rosType, string hash, int depth, double maxHz, Action<byte[], int> read) =>
            new Inbox(streamer, streamer.Bridge.Subscribe(topic, rosType, hash, depth, maxHz), true, read, null);

        /// <summary>Returns the inbox of a number, whose messages all wait for frames that have time.</summary>
        /// <param name="end">Called when the streamer is destroyed: nothing comes any more.</param>
        public static Inbox Of(Ml2SensorStreamer streamer, uint number, Action<byte[], int> read, Action end) =>
            new Inbox(streamer, number, false, read, end);

        /// <summary>Ends a subscription, and takes no more.</summary>
        public void Dispose()
        {
            if (_isDisposed) return;
            _isDisposed = true;
            _streamer.Pump.Remove(this);
            if (_isTopic) _streamer.Bridge.Unsubscribe(_number);
        }

        void IPumped.Take(Pump pump)
        {
            while (!_isDisposed && _number != 0)
            {
                if (pump.IsOver)
                {
                    if (_isTopic) NativeMethods.SkipMessages(_number);
                    return;
                }
                if (!TryTake(out int length)) return;
                _read(_bytes, length);
            }
        }

        void IPumped.End() => _end?.Invoke();

        /// <summary>Copies the oldest message that waits, so that no lease outlives this call.</summary>
        private bool TryTake(out int length)
        {
            NativeMessage message = NativeMessage.Sized();
            NativeResult result = NativeMethods.AcquireMessage(_number, ref message);
            if (result != NativeResult.Closed) LeftOut = (long)message.LeftOut;
            length = (int)message.SizeBytes;
            if (result != NativeResult.Ok) return false;
            if (_bytes.Length < length) _bytes = new byte[length + length / 2];
            Marshal.Copy(message.Data, _bytes, 0, length);
            PublishedNanos = message.PublishedNanos;
            MessageNumber = message.Number;
            NativeMethods.ReleaseMessage(_number, message.Slot);
            return true;
        }
    }

    internal interface IPumped
    {
        /// <summary>Delivers messages that wait, until pump.IsOver; then keeps the newest for the next frame.</summary>
        void Take(Pump pump);

        /// <summary>Called once nothing comes any more.</summary>
        void End();
    }

    /// <summary>Delivers what waits for subscribers, for 2 ms of each frame and the message that is under way then.</summary>
    internal sealed class Pump
    {
        private static readonly long Limit = Stopwatch.Frequency / 500;
        private readonly List<IPumped> _pumped = new List<IPumped>();
        private int _first;
        private long _until;

        /// <summary>Ticks of Stopwatch.</summary>
        public Func<long> Now { get; set; } = Stopwatch.GetTimestamp;

        /// <summary>True if the frame has no time left.</summary>
        public bool IsOver => Now() >= _until;

        public void Add(IPumped it) => _pumped.Add(it);

        public void Remove(IPumped it) => _pumped.Remove(it);

        /// <summary>Tells all that nothing comes any more.</summary>
        public void End()
        {
            foreach (IPumped it in _pumped.ToArray()) it.End();
        }

        /// <summary>Another one is the first in each frame, so that none waits for the time that others leave.</summary>
        public void Run()
        {
            int count = _pumped.Count;
            if (count == 0) return;
            _until = Now() + Limit;
            _first = (_first + 1) % count;
            // Their events may dispose some
            for (int i = 0; i < count && _pumped.Count > 0; i++) _pumped[(_first + i) % _pumped.Count].Take(this);
        }
    }
}
