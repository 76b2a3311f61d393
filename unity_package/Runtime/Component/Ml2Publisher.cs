using System;
using Ml2Sensors.Interop;
using Ml2Sensors.Messages;

namespace Ml2Sensors
{
    /// <summary>
    /// Publishes messages of a script on the topic custom/NAME under the receiver's prefix, through the streamer's session.
    /// Use it on the main thread. Messages are copied, so one message object can be reused.
    /// </summary>
    public sealed class Ml2Publisher<T> where T : class, IMessage, new()
    {
        private readonly CdrWriter _cdr = new CdrWriter();
        private readonly Ml2SensorStreamer _streamer;
        private readonly int _publisher;

        /// <param name="name">Lower-case letters, digits and underscores; begins with a letter.</param>
        /// <exception cref="ArgumentException">The name does not follow this rule.</exception>
        public Ml2Publisher(Ml2SensorStreamer streamer, string name)
        {
            if (!IsName(name)) throw new ArgumentException($"Expected a-z, 0-9 and _, beginning with a letter; found \"{name}\".", nameof(name));
            _streamer = streamer;
            _publisher = streamer.Bridge.OpenPublisher("custom/" + name, new T().RosType);
        }

        /// <summary>The current time of CLOCK_BOOTTIME, for Publish. Works on the headset only.</summary>
        public static long NowNanos => NativeMethods.Now();

        /// <summary>Why the receiver does not publish the topic; empty if it does.</summary>
        public string Refusal => _streamer.Bridge.Refusal(_publisher);

        /// <summary>Sends a message. First writes the stamp of its header, if it has one.</summary>
        /// <param name="captureNanos">The time of the measurement, CLOCK_BOOTTIME.</param>
        /// <returns>False if no receiver takes the topic, or if the message has a stamp and ROS time is not known.</returns>
        /// <exception cref="ArgumentException">A field is null, or an array has the wrong length.</exception>
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
