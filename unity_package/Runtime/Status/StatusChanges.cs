using System.Collections.Generic;
using System.Linq;

namespace Ml2Sensors
{
    /// <summary>Compares two statuses for events to raise. Functions are pure. Statuses in between may have been skipped.</summary>
    internal static class StatusChanges
    {
        public static bool HasConnected(Status before, Status now) => IsConnected(now) && !IsConnected(before);

        public static bool HasDisconnected(Status before, Status now) => IsConnected(before) && !IsConnected(now);

        public static bool HasPaired(Status before, Status now) => IsNew(before.Pairing, now.Pairing, PairingState.Paired);

        public static bool HasFailedToPair(Status before, Status now) => IsNew(before.Pairing, now.Pairing, PairingState.Failed);

        /// <summary>Returns true if the set of streams or their values have changed.</summary>
        public static bool HasNewConfiguration(Status before, Status now)
        {
            if (now.Streams.Count == 0) return false;
            if (before.Streams.Count != now.Streams.Count) return true;
            foreach (var stream in now.Streams)
                if (!before.Streams.TryGetValue(stream.Key, out var old) || !IsSame(old, stream.Value)) return true;
            return false;
        }

        /// <summary>Streams that do not run now and did, or had another reason.</summary>
        public static IEnumerable<KeyValuePair<string, StreamStatus>> Refused(Status before, Status now) =>
            now.Streams.Where(stream => stream.Value.State != StreamState.Running && !WasSo(before, stream.Key, stream.Value));

        private static bool WasSo(Status before, string id, StreamStatus now) =>
            before.Streams.TryGetValue(id, out StreamStatus old) && old.State == now.State && old.Reason == now.Reason;

        private static bool IsNew(PairingStatus before, PairingStatus now, PairingState state) =>
            now.State == state && (before.State != state || before.Number != now.Number);

        private static bool IsConnected(Status status) => status.State == ConnectionState.Connected;

        private static bool IsSame(StreamStatus a, StreamStatus b)
        {
            if (a.State != b.State || a.Reason != b.Reason || a.Values.Count != b.Values.Count) return false;
            foreach (var value in a.Values)
                if (!b.Values.TryGetValue(value.Key, out string other) || other != value.Value) return false;
            return true;
        }
    }
}
