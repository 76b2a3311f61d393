using System;
using System.Runtime.InteropServices;
using Ml2Sensors.Interop;
using Ml2Sensors.Messages;

namespace Ml2Sensors.Tests
{
    /// <summary>
    /// An inbox of the native library, which Kotlin fills in the product; or an outbox, which Kotlin reads. Dispose fails while
    /// a message is leased.
    /// </summary>
    internal sealed class NativeInbox : IDisposable
    {
        private readonly CdrWriter _cdr = new CdrWriter();
        private uint _added;

        public NativeInbox(int depth)
        {
            Require(Open((uint)depth, out uint number));
            Number = number;
        }

        public uint Number { get; }

        public void Add(IMessage message)
        {
            _cdr.WritePayload(message);
            Add(_cdr.Buffer, _cdr.Length);
        }

        /// <param name="number">0: one more than the last.</param>
        public void Add(byte[] payload, int length, uint number = 0)
        {
            NativeMessage message = NativeMessage.Sized();
            Require(NativeMethods.TakeMessage(Number, (ulong)length, out message.Slot, out NativeMemory memory));
            Marshal.Copy(payload, 0, memory.Data, length);
            message.SizeBytes = (ulong)length;
            message.Number = number == 0 ? ++_added : number;
            message.PublishedNanos = 1000 * message.Number;
            Require(NativeMethods.AddMessage(Number, ref message));
        }

        /// <summary>Takes the oldest message that waits; null if there is none.</summary>
        public byte[] Take(out long nanos)
        {
            NativeMessage message = NativeMessage.Sized();
            NativeResult result = NativeMethods.AcquireMessage(Number, ref message);
            nanos = message.PublishedNanos;
            LeftOut = (long)message.LeftOut;
            LastNumber = message.Number;
            if (result != NativeResult.Ok) return null;
            var payload = new byte[message.SizeBytes];
            Marshal.Copy(message.Data, payload, 0, payload.Length);
            Require(NativeMethods.ReleaseMessage(Number, message.Slot));
            return payload;
        }

        public byte[] Take() => Take(out _);

        /// <summary>The number of the message that was taken last.</summary>
        public uint LastNumber { get; private set; }

        /// <summary>The number of messages that newer ones have replaced, as of the last Take.</summary>
        public long LeftOut { get; private set; }

        public void Dispose()
        {
            Require(Close(Number));
            for (uint slot = 0; slot < 102; slot++)
                if (NativeMethods.ReleaseMessage(Number, slot) == NativeResult.Ok) throw new InvalidOperationException("a message is leased");
        }

        private static void Require(NativeResult result)
        {
            if (result != NativeResult.Ok) throw new InvalidOperationException(result.ToString());
        }

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_inbox_open")]
        private static extern NativeResult Open(uint depth, out uint inbox);

        [DllImport(NativeMethods.Library, EntryPoint = "ml2s_inbox_close")]
        private static extern NativeResult Close(uint inbox);
    }
}
