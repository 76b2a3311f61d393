using System;
using System.Runtime.InteropServices;
using NUnit.Framework;

namespace Ml2Sensors.Tests
{
    /// <summary>The controls of the simulated headset, native/sim/ml2sim.h.</summary>
    internal static unsafe class Simulation
    {
        private const string Library = "libperception.magicleap.so";

        public static void Begin()
        {
            Reset();
            Set("clock", "manual");
            Set("loop_seconds", "2");
            Set("cache", Environment.GetEnvironmentVariable("ML2_FRAME_CACHE") ?? "");
            Advance(1000000000);
        }

        public static void Set(string key, string value)
        {
            IntPtr problem = SetKey(key, value);
            if (problem != IntPtr.Zero) throw new ArgumentException(Marshal.PtrToStringAnsi(problem));
        }

        /// <summary>Asserts that nothing is open and that no API rule was broken.</summary>
        public static void AssertNothingLeaked()
        {
            GetCounters(out Counters counters);
            Assert.AreEqual("", Marshal.PtrToStringAnsi((IntPtr)counters.LastMisuse));
            Assert.AreEqual(0, counters.OpenHandles + counters.OutstandingGets + counters.OutstandingSnapshots);
        }

        [StructLayout(LayoutKind.Sequential)]
        private struct Counters
        {
            internal uint OpenHandles;
            internal uint OutstandingGets;
            internal uint OutstandingSnapshots;
            internal uint OutstandingCapabilityLists;
            internal uint IsPerceptionStarted;
            internal fixed uint Misuses[8];
            internal fixed byte LastMisuse[240];
        }

        [DllImport(Library, EntryPoint = "ml2sim_reset")]
        private static extern void Reset();

        [DllImport(Library, EntryPoint = "ml2sim_set")]
        private static extern IntPtr SetKey(string key, string value);

        [DllImport(Library, EntryPoint = "ml2sim_advance")]
        public static extern void Advance(long nanos);

        [DllImport(Library, EntryPoint = "ml2sim_get_counters")]
        private static extern void GetCounters(out Counters counters);
    }
}
