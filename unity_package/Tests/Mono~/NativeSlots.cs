using System;
using System.Runtime.InteropServices;
using Ml2Sensors.Interop;

namespace Ml2Sensors.Tests
{
    /// <summary>The memory of a stream's slots. Dispose fails while a slot is leased.</summary>
    internal sealed unsafe class NativeSlots : IDisposable
    {
        private const int Alignment = 64;
        private readonly StreamId _stream;
        private readonly IntPtr _memory;

        public NativeSlots(StreamId stream, int count, int sizeBytes)
        {
            _stream = stream;
            int step = (sizeBytes + Alignment - 1) / Alignment * Alignment;
            _memory = Marshal.AllocHGlobal(count * step + Alignment);
            long start = ((long)_memory + Alignment - 1) / Alignment * Alignment;
            var slots = new Memory[count];
            for (int i = 0; i < count; i++) slots[i] = new Memory { Data = (byte*)start + (long)i * step, SizeBytes = (ulong)sizeBytes };
            fixed (Memory* first = slots) Require(Provide(stream, first, (uint)count));
        }

        /// <summary>Publishes a frame, as Kotlin does for sensors without a native source.</summary>
        public void Publish(long captureNanos, byte[] bytes, int width = 0, int height = 0, int rowBytes = 0) =>
            Publish(captureNanos, bytes, NativeFrame.Sized(), width, height, rowBytes);

        /// <summary>Publishes a frame with the poses and lens of <paramref name="frame"/>.</summary>
        public void Publish(long captureNanos, byte[] bytes, NativeFrame frame, int width, int height, int rowBytes = 0)
        {
            Require(Take(_stream, out frame.Slot, out Memory memory));
            Marshal.Copy(bytes, 0, (IntPtr)memory.Data, bytes.Length);
            frame.Stream = _stream;
            frame.CaptureNanos = captureNanos;
            frame.Image.SizeBytes = (uint)bytes.Length;
            frame.Image.StrideBytes = (uint)rowBytes;
            frame.Width = (uint)width;
            frame.Height = (uint)height;
            Require(PublishFrame(ref frame));
            Require(NativeMethods.Release(_stream, frame.Slot));
        }

        public void Dispose()
        {
            Require(Provide(_stream, null, 0));
            Marshal.FreeHGlobal(_memory);
        }

        private void Require(NativeResult result)
        {
            if (result != NativeResult.Ok) throw new InvalidOperationException($"{_stream}: {result}");
        }

        [StructLayout(LayoutKind.Sequential)]
        private struct Memory
        {
            internal byte* Data;
            internal ulong SizeBytes;
        }

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_provide")]
        private static extern NativeResult Provide(StreamId stream, Memory* slots, uint count);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_take")]
        private static extern NativeResult Take(StreamId stream, out uint slot, out Memory memory);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_publish")]
        internal static extern NativeResult PublishFrame(ref NativeFrame frame);
    }
}
