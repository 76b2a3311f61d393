using System;
using System.Runtime.InteropServices;
using Ml2Sensors.Interop;

namespace Ml2Sensors.Tests
{
    /// <summary>Opens a simulated sensor by ml2s.h and polls it, which Kotlin does in the product.</summary>
    internal sealed unsafe class NativeSensor : IDisposable
    {
        private readonly ulong _handle;

        public NativeSensor(uint sensor, params StreamId[] streams)
        {
            var settings = new Settings { StructSize = (uint)sizeof(Settings), Sensor = sensor, RateHz = 30 };
            foreach (StreamId stream in streams) settings.Streams |= 1UL << (int)stream;
            if (sensor == Depth) settings.SecondStreams = settings.Streams;
            NativeError error = NativeError.Sized();
            Check(Open(ref settings, out _handle, ref error), ref error);
        }

        public const uint Depth = 1;
        public const uint World = 2;
        public const uint Eye = 3;

        /// <summary>Captures and publishes once, as Kotlin does for a stream with readers.</summary>
        public int Capture()
        {
            NativeFrame* frames = stackalloc NativeFrame[4];
            for (int i = 0; i < 4; i++) frames[i] = NativeFrame.Sized();
            NativeError error = NativeError.Sized();
            NativeResult result = Poll(_handle, 0, frames, 4, out uint count, ref error);
            if (result == NativeResult.Timeout) return 0;
            Check(result, ref error);
            for (int i = 0; i < count; i++)
            {
                Check(NativeSlots.PublishFrame(ref frames[i]), ref error);
                Check(NativeMethods.Release(frames[i].Stream, frames[i].Slot), ref error);
            }
            return (int)count;
        }

        public void Dispose()
        {
            NativeError error = NativeError.Sized();
            Check(Close(_handle, ref error), ref error);
        }

        private static void Check(NativeResult result, ref NativeError error)
        {
            if (result != NativeResult.Ok) throw new InvalidOperationException($"{result}: {error.Message}");
        }

        [StructLayout(LayoutKind.Sequential)]
        private struct Settings
        {
            internal uint StructSize;
            internal uint Sensor;
            internal uint Backend;
            internal uint Wants;
            internal ulong Streams;
            internal ulong SecondStreams;
            internal uint RateHz;
            internal uint Width;
            internal uint Height;
            internal uint Reserved;
        }

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_open")]
        private static extern NativeResult Open(ref Settings settings, out ulong handle, ref NativeError error);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_poll")]
        private static extern NativeResult Poll(
            ulong handle, ulong timeoutNanos, NativeFrame* frames, uint capacity, out uint count, ref NativeError error);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_close")]
        private static extern NativeResult Close(ulong handle, ref NativeError error);
    }
}
