using System;
using System.Runtime.InteropServices;
using System.Text.RegularExpressions;
using Ml2Sensors.Interop;
using Ml2Sensors.Messages;

namespace Ml2Sensors
{
    /// <summary>
    /// Publishes messages of a script, through the streamer's session. Use it on the main thread. Publishing calls no Java and
    /// allocates nothing. Messages are copied, so one message object can be reused.
    /// </summary>
    public sealed class Ml2Publisher<T> where T : class, IMessage, new()
    {
        private static readonly Regex Name = new Regex("^([a-z][a-z0-9_]*|(/[A-Za-z](_?[A-Za-z0-9])*)+)$");
        private readonly CdrWriter _cdr = new CdrWriter();
        private readonly Outbox _outbox;

        /// <param name="name">
        /// Lower-case letters, digits and underscores, beginning with a letter: the topic is custom/NAME under the receiver's
        /// prefix. Or an absolute name such as "/cmd_vel", which the receiver's user has to allow (app.publish).
        /// </param>
        /// <param name="latched">True keeps the newest message for late subscribers (transient local).</param>
        /// <param name="large">True allows messages of up to 16 MiB, which give way to sensors; false 64 KiB.</param>
        /// <param name="depth">
        /// How many messages may wait until they are sent, 1 to 100: the newest ones. 1 is the newest alone. The receiver counts
        /// what newer ones have replaced, as queue_full.
        /// </param>
        /// <exception cref="ArgumentException">The name does not follow this rule, or the depth is not from 1 to 100.</exception>
        public Ml2Publisher(Ml2SensorStreamer streamer, string name, bool latched = false, bool large = false, int depth = 10)
        {
            if (!Name.IsMatch(name ?? ""))
                throw new ArgumentException($"Expected a-z, 0-9 and _, beginning with a letter, or an absolute name of ROS; found \"{name}\".", nameof(name));
            if (depth < 1 || depth > 100) throw new ArgumentException($"Expected 1 to 100, found {depth}.", nameof(depth));
            var message = new T();
            _outbox = new Outbox(streamer, name[0] == '/' ? name : "custom/" + name, message.RosType, latched, large, message is IStamped, depth);
        }

        /// <summary>The current time of CLOCK_BOOTTIME, for Publish. Works on the headset only.</summary>
        public static long NowNanos => NativeMethods.Now();

        /// <summary>The reason why the receiver does not publish the topic; empty if it does. Not for each frame: it calls Java.</summary>
        public string Refusal => _outbox.Refusal;

        /// <summary>Sends a message. In the message that is sent, the stamp of its header is the capture time.</summary>
        /// <param name="captureNanos">The time of the measurement, CLOCK_BOOTTIME.</param>
        /// <returns>False if no session runs: the message is not sent.</returns>
        /// <exception cref="ArgumentException">A field is null, an array has the wrong length, or the message is too large.</exception>
        public bool Publish(T message, long captureNanos)
        {
            _cdr.WritePayload(message);
            return _outbox.Add(_cdr.Buffer, _cdr.Length, captureNanos);
        }
    }

    /// <summary>Messages of a topic, or requests of a service, that wait in native memory until the library sends them.</summary>
    internal sealed class Outbox
    {
        public const int SmallBytes = 64 << 10;
        private const int LargeBytes = 16 << 20;
        private readonly Ml2SensorStreamer _streamer;
        private readonly uint _number;
        private readonly int _mostBytes;

        /// <param name="isStamped">True if messages begin with a header, whose stamp the library writes.</param>
        public Outbox(Ml2SensorStreamer streamer, string topic, string rosType, bool isLatched, bool isLarge, bool isStamped, int depth)
            : this(streamer, streamer.Bridge.OpenPublisher(topic, rosType, isLatched, isLarge, isStamped, depth), isLarge ? LargeBytes : SmallBytes)
        {
        }

        /// <param name="number">0 where nothing is sent.</param>
        public Outbox(Ml2SensorStreamer streamer, uint number, int mostBytes = SmallBytes)
        {
            _streamer = streamer;
            _number = number;
            _mostBytes = mostBytes;
            if (_number != 0) NativeMethods.CheckVersion();
        }

        public string Refusal => _streamer.Bridge.PublisherRefusal(_number);

        /// <summary>Copies a message. Returns false if no session runs, or if there is no memory.</summary>
        /// <exception cref="ArgumentException">The bytes are none of a message, or too many.</exception>
        public bool Add(byte[] payload, int length, long captureNanos)
        {
            string wrong = Wrong(payload, length);
            if (wrong != null) throw new ArgumentException(wrong, nameof(payload));
            return _streamer.Status.State == ConnectionState.Connected && Put(payload, length, captureNanos, 0);
        }

        /// <summary>Says what is wrong with a message; null if it can be sent.</summary>
        public string Wrong(byte[] payload, int length)
        {
            if (length > _mostBytes) return $"Expected a message of at most {_mostBytes} bytes, found {length}.";
            bool isCdr = length >= 4 && payload[0] == 0 && payload[1] == 1 && payload[2] == 0 && payload[3] == 0;
            return isCdr ? null : "Expected CDR after 00 01 00 00, found other bytes.";
        }

        /// <summary>Copies bytes with a time and a number, also without a session. Returns false if there is no memory.</summary>
        public bool Put(byte[] bytes, int length, long nanos, uint number)
        {
            NativeMessage message = NativeMessage.Sized();
            if (_number == 0 || NativeMethods.TakeMessage(_number, (ulong)length, out message.Slot, out NativeMemory memory) != NativeResult.Ok)
                return false;
            Marshal.Copy(bytes, 0, memory.Data, length);
            message.SizeBytes = (ulong)length;
            message.PublishedNanos = nanos;
            message.Number = number;
            return NativeMethods.AddMessage(_number, ref message) == NativeResult.Ok;
        }
    }
}
