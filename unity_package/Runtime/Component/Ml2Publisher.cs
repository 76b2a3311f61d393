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

        /// <param name="captureNanos">CLOCK_BOOTTIME of the measurement; the library makes the header's stamp of it.</param>
        /// <returns>False when it was dropped, which the library counts.</returns>
        /// <exception cref="ArgumentException">A field is null or has another length than its type.</exception>
        public bool Publish(T message, long captureNanos)
        {
            _cdr.WritePayload(message);
            return _streamer.Bridge.Publish(_publisher, _cdr.Buffer, _cdr.Length, captureNanos);
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
