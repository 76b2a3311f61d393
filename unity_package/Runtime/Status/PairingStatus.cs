using System.Collections.Generic;

namespace Ml2Sensors
{
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

        /// <summary>Why the pairing failed; else empty.</summary>
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
