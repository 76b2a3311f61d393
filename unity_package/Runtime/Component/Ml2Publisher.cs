using System;
using Ml2Sensors.Interop;
using Ml2Sensors.Messages;

namespace Ml2Sensors
{
    /// <summary>
    /// Publishes messages of a script as the topic custom/NAME under the receiver's prefix, through the streamer's session.
    /// Main thread. Messages are copied, so one object can be filled anew for each.
    /// </summary>
    public sealed class Ml2Publisher<T> where T : class, IMessage, new()
    {
        private readonly CdrWriter _cdr = new CdrWriter();
        private readonly Ml2SensorStreamer _streamer;
        private readonly int _publisher;

        /// <param name="name">Lower-case letters, digits and underscores, beginning with a letter.</param>
        /// <exception cref="ArgumentException">The name is another.</exception>
        public Ml2Publisher(Ml2SensorStreamer streamer, string name)
        {
            if (!IsName(name)) throw new ArgumentException($"Expected a-z, 0-9 and _, beginning with a letter; found \"{name}\".", nameof(name));
            _streamer = streamer;
            _publisher = streamer.Bridge.OpenPublisher("custom/" + name, new T().RosType);
        }

        /// <summary>Now, as CLOCK_BOOTTIME: what Publish wants. Only on the headset.</summary>
        public static long NowNanos => NativeMethods.Now();

        /// <summary>Why the receiver does not publish the topic; empty as long as it does.</summary>
        public string Refusal => _streamer.Bridge.Refusal(_publisher);

        /// <summary>Sends a message, after writing its header's stamp if it has one.</summary>
        /// <param name="captureNanos">CLOCK_BOOTTIME of the measurement.</param>
        /// <returns>False while no receiver takes it, or ROS time is not known and the message has a stamp.</returns>
        /// <exception cref="ArgumentException">A field is null or has another length than its type.</exception>
        public bool Publish(T message, long captureNanos)
        {
            if (message is IStamped stamped && !TryStamp(stamped.Header, captureNanos)) return false;
            _cdr.WritePayload(message);
            return _streamer.Bridge.Publish(_publisher, _cdr.Buffer, _cdr.Length, captureNanos);
        }

        private bool TryStamp(HeaderMsg header, long captureNanos)
        {
            const long NanosPerSecond = 1000000000;
            long stampNanos = _streamer.Bridge.StampNanos(captureNanos);
            if (stampNanos == 0) return false;
            header.stamp.sec = checked((int)(stampNanos / NanosPerSecond));
            header.stamp.nanosec = (uint)(stampNanos % NanosPerSecond);
            return true;
        }

        private static bool IsName(string name)
        {
            if (string.IsNullOrEmpty(name) || name[0] < 'a' || name[0] > 'z') return false;
            foreach (char c in name)
                if (!((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_')) return false;
            return true;
        }
    }
}
