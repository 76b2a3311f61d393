using System.Collections.Generic;
using UnityEngine.Android;

namespace Ml2Sensors
{
    /// <summary>
    /// Requests each permission once. An answer may arrive on any thread, or never: Android ends a request without one
    /// when it is interrupted. So Look says which permissions are missing. All methods are called on the main thread.
    /// </summary>
    internal sealed class PermissionRequests
    {
        private readonly object _lock = new object();
        private readonly HashSet<string> _asked = new HashSet<string>();
        private readonly HashSet<string> _unanswered = new HashSet<string>();
        private readonly HashSet<string> _cancelled = new HashSet<string>();
        private readonly HashSet<string> _missing = new HashSet<string>();
        private bool _hasNew;

        /// <summary>True while the user has not answered all requests.</summary>
        public bool IsWaiting
        {
            get
            {
                lock (_lock) return _unanswered.Count > 0;
            }
        }

        /// <summary>Returns true if a permission was granted since the last call.</summary>
        public bool TakeGranted()
        {
            lock (_lock)
            {
                bool hasNew = _hasNew;
                _hasNew = false;
                return hasNew;
            }
        }

        /// <summary>Notes which permissions are missing now. Those that no longer are were granted.</summary>
        /// <param name="isInFront">True if no dialog is open: requests without an answer are over.</param>
        public void Look(IReadOnlyList<PermissionNeed> needs, bool isInFront)
        {
            var now = new HashSet<string>();
            foreach (PermissionNeed need in needs) now.Add(need.Permission);
            lock (_lock)
            {
                _hasNew |= _missing.RemoveWhere(permission => !now.Contains(permission)) > 0;
                _missing.UnionWith(now);
                if (isInFront) _cancelled.UnionWith(_unanswered);
                if (isInFront) _unanswered.Clear();
                else _unanswered.IntersectWith(now);
            }
        }

        /// <summary>Allows to request again what was requested without an answer.</summary>
        public void ForgetCancelled()
        {
            lock (_lock)
            {
                _asked.ExceptWith(_cancelled);
                _cancelled.Clear();
            }
        }

        /// <summary>Returns the needs that were not requested yet, and marks them as requested.</summary>
        public List<PermissionNeed> TakeNew(IReadOnlyList<PermissionNeed> needs)
        {
            var found = new List<PermissionNeed>();
            lock (_lock)
            {
                foreach (PermissionNeed need in needs)
                    if (_asked.Add(need.Permission)) found.Add(need);
            }
            return found;
        }

        public void Ask(IReadOnlyList<PermissionNeed> needs)
        {
            if (needs.Count == 0) return;
            var names = new string[needs.Count];
            for (int i = 0; i < names.Length; i++) names[i] = needs[i].Permission;
            lock (_lock) _unanswered.UnionWith(names);
            var callbacks = new PermissionCallbacks();
            callbacks.PermissionGranted += permission => Answered(permission, true);
            callbacks.PermissionDenied += permission => Answered(permission, false);
            Permission.RequestUserPermissions(names, callbacks);
        }

        private void Answered(string permission, bool isGranted)
        {
            lock (_lock)
            {
                _unanswered.Remove(permission);
                _cancelled.Remove(permission);
                // Else Look has found it
                if (isGranted) _hasNew |= _missing.Remove(permission);
            }
        }
    }
}
