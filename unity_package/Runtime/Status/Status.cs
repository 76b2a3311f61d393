using System.Collections.Generic;

namespace Ml2Sensors
{
    /// <summary>How it stands with the receiver.</summary>
    public enum ConnectionState
    {
        /// <summary>Not started, stopped, or a recording is over.</summary>
        Ended,

        /// <summary>Looking for it, or being refused; Status.Reason may say why.</summary>
        Connecting,

        /// <summary>In a session.</summary>
        Connected,
    }

    /// <summary>What became of a stream that the receiver asked for.</summary>
    public enum StreamState
    {
        /// <summary>It runs.</summary>
        Accepted,

        /// <summary>The headset does not start it.</summary>
        Refused,

        /// <summary>Its source failed for good; only a recording's does.</summary>
        Failed,

        /// <summary>It was accepted and its source failed or ended; the library opens it again until it runs.</summary>
        Waiting,
    }

    /// <summary>What the library said of itself at one moment. Immutable.</summary>
    public sealed class Status
    {
        internal static readonly Status Initial = new Status(
            ConnectionState.Ended, "", "", false, new Dictionary<string, StreamStatus>(), new Dictionary<string, ChannelCounts>(), null,
            PairingStatus.Initial);

        /// <summary>How it stands with the receiver.</summary>
        public readonly ConnectionState State;

        /// <summary>Its name or address; empty when none is known.</summary>
        public readonly string Receiver;

        /// <summary>Why it is not connected; empty when there is nothing to say.</summary>
        public readonly string Reason;

        /// <summary>Whether it was started without encryption.</summary>
        public readonly bool IsInsecure;

        /// <summary>By stream id.</summary>
        public readonly IReadOnlyDictionary<string, StreamStatus> Streams;

        /// <summary>By topic.</summary>
        public readonly IReadOnlyDictionary<string, ChannelCounts> Channels;

        /// <summary>Null until clocks were compared.</summary>
        public readonly ClockStatus Clock;

        /// <summary>With whom the headset is paired.</summary>
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

    /// <summary>How one stream runs, or why it does not. Immutable.</summary>
    public sealed class StreamStatus
    {
        /// <summary>What became of it.</summary>
        public readonly StreamState State;

        /// <summary>Why it waits, was refused, failed or adjusted; empty when it runs as asked for.</summary>
        public readonly string Reason;

        /// <summary>As applied, by the keys of config.yaml; numbers and truth values as JSON writes them.</summary>
        public readonly IReadOnlyDictionary<string, string> Values;

        internal StreamStatus(StreamState state, string reason, IReadOnlyDictionary<string, string> values)
        {
            State = state;
            Reason = reason;
            Values = values;
        }
    }

    /// <summary>Messages of one topic since the app started.</summary>
    public sealed class ChannelCounts
    {
        /// <summary>Made by the source, whether sent or dropped.</summary>
        public readonly long Produced;

        /// <summary>Handed to the network to the last byte.</summary>
        public readonly long Sent;

        /// <summary>By reason; PROTOCOL.md lists them.</summary>
        public readonly IReadOnlyDictionary<string, long> Dropped;

        internal ChannelCounts(long produced, long sent, IReadOnlyDictionary<string, long> dropped)
        {
            Produced = produced;
            Sent = sent;
            Dropped = dropped;
        }
    }

    /// <summary>How well the headset knows ROS time. Immutable.</summary>
    public sealed class ClockStatus
    {
        /// <summary>"waiting", "synchronised", "holdover" or "frozen".</summary>
        public readonly string State;

        /// <summary>ROS time minus CLOCK_BOOTTIME.</summary>
        public readonly long OffsetNanos;

        /// <summary>Of a stamp, either way.</summary>
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
        /// <summary>Android's name of it.</summary>
        public readonly string Permission;

        /// <summary>For the user.</summary>
        public readonly string Reason;

        /// <summary>The ids of those that need it.</summary>
        public readonly IReadOnlyList<string> Streams;

        internal PermissionNeed(string permission, string reason, IReadOnlyList<string> streams)
        {
            Permission = permission;
            Reason = reason;
            Streams = streams;
        }
    }
}
