using System.Collections.Generic;

namespace Ml2Sensors
{
    /// <summary>The state of the connection to the receiver.</summary>
    public enum ConnectionState
    {
        /// <summary>Not started, or stopped, or a replay is over.</summary>
        Ended,

        /// <summary>Trying to connect; Status.Reason may say why it does not succeed.</summary>
        Connecting,

        /// <summary>A session runs.</summary>
        Connected,
    }

    /// <summary>The state of a stream that the receiver requested.</summary>
    public enum StreamState
    {
        /// <summary>The stream runs.</summary>
        Running,

        /// <summary>The headset does not start the stream.</summary>
        Refused,

        /// <summary>The source failed permanently; this happens in replays only.</summary>
        Failed,

        /// <summary>The stream does not run now, because its source failed or ended. The library tries to reopen it.</summary>
        Waiting,
    }

    /// <summary>The status of the library at one time. Immutable.</summary>
    public sealed class Status
    {
        internal static readonly Status Initial = new Status(
            ConnectionState.Ended, "", "", false, new Dictionary<string, StreamStatus>(), new Dictionary<string, ChannelCounts>(), null,
            PairingStatus.Initial);

        /// <summary>The state of the connection to the receiver.</summary>
        public readonly ConnectionState State;

        /// <summary>The receiver's name or address; empty if not known.</summary>
        public readonly string Receiver;

        /// <summary>The reason why it is not connected; may be empty.</summary>
        public readonly string Reason;

        /// <summary>True if it was started without encryption.</summary>
        public readonly bool IsInsecure;

        /// <summary>The status of each stream, by stream id.</summary>
        public readonly IReadOnlyDictionary<string, StreamStatus> Streams;

        /// <summary>The message counts of each topic.</summary>
        public readonly IReadOnlyDictionary<string, ChannelCounts> Channels;

        /// <summary>The clock status; null until clocks were compared.</summary>
        public readonly ClockStatus Clock;

        /// <summary>The paired receivers, and the result of the last pairing.</summary>
        public readonly PairingStatus Pairing;

        internal Status(
            ConnectionState state, string receiver, string reason, bool isInsecure,
            IReadOnlyDictionary<string, StreamStatus> streams, IReadOnlyDictionary<string, ChannelCounts> channels,
            ClockStatus clock, PairingStatus pairing)
        {
            State = state;
            Receiver = receiver;
            Reason = reason;
            IsInsecure = isInsecure;
            Streams = streams;
            Channels = channels;
            Clock = clock;
            Pairing = pairing;
        }
    }

    /// <summary>The status of one stream. Immutable.</summary>
    public sealed class StreamStatus
    {
        /// <summary>The state of the stream.</summary>
        public readonly StreamState State;

        /// <summary>The reason why it waits, was refused, failed or was adjusted; empty if it runs as asked.</summary>
        public readonly string Reason;

        /// <summary>The applied values, by the keys of config.yaml; numbers and booleans as JSON writes them.</summary>
        public readonly IReadOnlyDictionary<string, string> Values;

        internal StreamStatus(StreamState state, string reason, IReadOnlyDictionary<string, string> values)
        {
            State = state;
            Reason = reason;
            Values = values;
        }
    }

    /// <summary>Counts of the messages of one topic since the app started.</summary>
    public sealed class ChannelCounts
    {
        /// <summary>Messages that the source made, whether sent or dropped.</summary>
        public readonly long Produced;

        /// <summary>Messages that were written to the network completely.</summary>
        public readonly long Sent;

        /// <summary>Dropped messages by reason; PROTOCOL.md lists the reasons.</summary>
        public readonly IReadOnlyDictionary<string, long> Dropped;

        internal ChannelCounts(long produced, long sent, IReadOnlyDictionary<string, long> dropped)
        {
            Produced = produced;
            Sent = sent;
            Dropped = dropped;
        }
    }

    /// <summary>The accuracy of ROS time on the headset. Immutable.</summary>
    public sealed class ClockStatus
    {
        /// <summary>"waiting", "synchronised", "holdover" or "frozen".</summary>
        public readonly string State;

        /// <summary>ROS time minus CLOCK_BOOTTIME.</summary>
        public readonly long OffsetNanos;

        /// <summary>The largest error of a stamp, in both directions.</summary>
        public readonly long UncertaintyNanos;

        internal ClockStatus(string state, long offsetNanos, long uncertaintyNanos)
        {
            State = state;
            OffsetNanos = offsetNanos;
            UncertaintyNanos = uncertaintyNanos;
        }
    }

    /// <summary>A permission that streams lack.</summary>
    public sealed class PermissionNeed
    {
        /// <summary>Android's name of the permission.</summary>
        public readonly string Permission;

        /// <summary>A reason to show to the user.</summary>
        public readonly string Reason;

        /// <summary>The ids of the streams that need it.</summary>
        public readonly IReadOnlyList<string> Streams;

        internal PermissionNeed(string permission, string reason, IReadOnlyList<string> streams)
        {
            Permission = permission;
            Reason = reason;
            Streams = streams;
        }
    }

    /// <summary>The result of the last pairing.</summary>
    public enum PairingState
    {
        /// <summary>No pairing was tried since the app started.</summary>
        None,

        /// <summary>The pairing runs.</summary>
        Running,

        /// <summary>It succeeded; the receiver is the last of PairingStatus.Receivers.</summary>
        Paired,

        /// <summary>It failed; PairingStatus.Reason says why.</summary>
        Failed,
    }

    /// <summary>The receivers that this headset is paired with, and the result of the last pairing. Immutable.</summary>
    public sealed class PairingStatus
    {
        internal static readonly PairingStatus Initial = new PairingStatus(0, PairingState.None, "", new PairedReceiver[0]);

        /// <summary>The result of the last pairing.</summary>
        public readonly PairingState State;

        /// <summary>The reason of a failed pairing; else empty.</summary>
        public readonly string Reason;

        /// <summary>The paired receivers, in the order of pairing.</summary>
        public readonly IReadOnlyList<PairedReceiver> Receivers;

        /// <summary>The number of pairings tried since the app started.</summary>
        internal readonly int Number;

        internal PairingStatus(int number, PairingState state, string reason, IReadOnlyList<PairedReceiver> receivers)
        {
            Number = number;
            State = state;
            Reason = reason;
            Receivers = receivers;
        }
    }

    /// <summary>A receiver that this headset is paired with.</summary>
    public sealed class PairedReceiver
    {
        /// <summary>The name that it announces.</summary>
        public readonly string Name;

        /// <summary>The SHA-256 of its certificate, 64 hexadecimal digits.</summary>
        public readonly string Fingerprint;

        /// <summary>The address at which it was paired, "host:port".</summary>
        public readonly string Address;

        internal PairedReceiver(string name, string fingerprint, string address)
        {
            Name = name;
            Fingerprint = fingerprint;
            Address = address;
        }
    }
}
