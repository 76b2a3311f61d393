using System.Collections.Generic;
using System.Threading;
using UnityEngine.Android;

namespace Ml2Sensors
{
    /// <summary>Requests each permission once. Answers arrive on any thread; the properties are read on the main thread.</summary>
    internal sealed class PermissionRequests
    {
        private readonly HashSet<string> _asked = new HashSet<string>();
        private int _open;
        private int _granted;

        /// <summary>True while the user has not answered all requests.</summary>
        public bool IsWaiting => Volatile.Read(ref _open) > 0;

        /// <summary>Returns true if a permission was granted since the last call.</summary>
        public bool TakeGranted() => Interlocked.Exchange(ref _granted, 0) > 0;

        /// <summary>Returns the needs that were not requested yet, and marks them as requested.</summary>
        public List<PermissionNeed> TakeNew(IReadOnlyList<PermissionNeed> needs)
        {
            var found = new List<PermissionNeed>();
            foreach (PermissionNeed need in needs)
                if (_asked.Add(need.Permission)) found.Add(need);
            return found;
        }

        public void Ask(IReadOnlyList<PermissionNeed> needs)
        {
            if (needs.Count == 0) return;
            var names = new string[needs.Count];
            for (int i = 0; i < names.Length; i++) names[i] = needs[i].Permission;
            Interlocked.Add(ref _open, names.Length);
            var callbacks = new PermissionCallbacks();
            callbacks.PermissionGranted += _ =>
            {
                Interlocked.Exchange(ref _granted, 1);
                Interlocked.Decrement(ref _open);
            };
            callbacks.PermissionDenied += _ => Interlocked.Decrement(ref _open);
            Permission.RequestUserPermissions(names, callbacks);
        }
    }
}
