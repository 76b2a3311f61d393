using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Ml2Sensors.Interop;

namespace Ml2Sensors.Tests
{
    /// <summary>The slots of a stream. Dispose fails while one is leased.</summary>
    internal sealed unsafe class NativeSlots : IDisposable
    {
        private const int Count = 8;
        private readonly StreamId _stream;

        public NativeSlots(StreamId stream)
        {
            _stream = stream;
            Require(Reserve(stream));
        }

        /// <summary>Publishes a frame, as Kotlin does for sensors without a native source.</summary>
        public void Publish(long captureNanos, byte[] bytes, int width = 0, int height = 0, int rowBytes = 0) =>
            Publish(captureNanos, bytes, NativeFrame.Sized(), width, height, rowBytes);

        /// <summary>Publishes a frame with the poses and lens of <paramref name="frame"/>.</summary>
        public void Publish(long captureNanos, byte[] bytes, NativeFrame frame, int width, int height, int rowBytes = 0)
        {
            Require(Take(_stream, (ulong)bytes.Length, out frame.Slot, out Memory memory));
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
            Require(Unpublish(_stream));
            var idle = new List<uint>();
            uint free;
            Memory memory;
            while (Take(_stream, 1, out free, out memory) == NativeResult.Ok) idle.Add(free);
            foreach (uint slot in idle) Require(NativeMethods.Release(_stream, slot));
            if (idle.Count < Count) throw new InvalidOperationException($"{_stream}: {Count - idle.Count} slots are leased");
            Require(Retire(_stream));
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

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_reserve")]
        private static extern NativeResult Reserve(StreamId stream);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_retire")]
        private static extern NativeResult Retire(StreamId stream);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_unpublish")]
        private static extern NativeResult Unpublish(StreamId stream);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_take")]
        private static extern NativeResult Take(StreamId stream, ulong sizeBytes, out uint slot, out Memory memory);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_publish")]
        internal static extern NativeResult PublishFrame(ref NativeFrame frame);
    }
}
