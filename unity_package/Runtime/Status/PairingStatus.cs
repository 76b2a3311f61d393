using System.Collections.Generic;

namespace Ml2Sensors
{
    /// <summary>What became of the last pairing.</summary>
    public enum PairingState
    {
        /// <summary>None was tried since the app started.</summary>
        None,

        /// <summary>The receiver is being asked.</summary>
        Running,

        /// <summary>The receiver is the last of PairingStatus.Receivers.</summary>
        Paired,

        /// <summary>PairingStatus.Reason says why.</summary>
        Failed,
    }

    /// <summary>With whom this headset is paired, and what became of the last pairing. Immutable.</summary>
    public sealed class PairingStatus
    {
        internal static readonly PairingStatus Initial = new PairingStatus(0, PairingState.None, "", new PairedReceiver[0]);

        /// <summary>What became of the last pairing.</summary>
        public readonly PairingState State;

        /// <summary>Why it failed; else empty.</summary>
        public readonly string Reason;

        /// <summary>In the order in which they were paired.</summary>
        public readonly IReadOnlyList<PairedReceiver> Receivers;

        /// <summary>How many were tried since the app started.</summary>
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
        /// <summary>As it announces itself.</summary>
        public readonly string Name;

        /// <summary>SHA-256 of its certificate, 64 hexadecimal digits.</summary>
        public readonly string Fingerprint;

        /// <summary>Where it was paired, "host:port".</summary>
        public readonly string Address;

        internal PairedReceiver(string name, string fingerprint, string address)
        {
            Name = name;
            Fingerprint = fingerprint;
            Address = address;
        }
    }
}
