using System;
using System.Text;

namespace Ml2Sensors.Messages
{
    /// <summary>
    /// Encodes messages as plain little-endian CDR after a 4-byte encapsulation header, the bytes that ROS 2 sends. The
    /// buffer grows to the largest message and is reused. Not thread-safe.
    /// </summary>
    public sealed class CdrWriter
    {
        private const int HeaderBytes = 4;
        private static readonly UTF8Encoding Utf8 = new UTF8Encoding(false, true);
        private byte[] _bytes = new byte[256];

        /// <summary>The length of the payload, from the start of Buffer.</summary>
        public int Length { get; private set; }

        /// <summary>The payload; valid until the next write.</summary>
        public byte[] Buffer => _bytes;

        /// <summary>Replaces the buffer's content by a message.</summary>
        /// <exception cref="ArgumentException">A field is null, has the wrong length, or is not valid Unicode.</exception>
        public void WritePayload(IMessage message)
        {
            Length = 0;
            Reserve(HeaderBytes, 1);
            _bytes[1] = 1;
            message.Write(this);
        }

#pragma warning disable 1591 // One for each type of a field.
        public void Write(bool value) => Write((byte)(value ? 1 : 0));

        public void Write(sbyte value) => Write((byte)value);

        public void Write(byte value) => Put(value, 1);

        public void Write(short value) => Put((ulong)value, 2);

        public void Write(ushort value) => Put(value, 2);

        public void Write(int value) => Put((ulong)value, 4);

        public void Write(uint value) => Put(value, 4);

        public void Write(long value) => Put((ulong)value, 8);

        public void Write(ulong value) => Put(value, 8);

        public unsafe void Write(float value) => Put(*(uint*)&value, 4);

        public void Write(double value) => Put((ulong)BitConverter.DoubleToInt64Bits(value), 8);

        public void Write(string value)
        {
            if (value == null) throw new ArgumentNullException(nameof(value), "Expected a string in each string field of a message, found null.");
            int count = Utf8.GetByteCount(value);
            Write((uint)count + 1);
            int at = Reserve(count + 1, 1);
            Utf8.GetBytes(value, 0, value.Length, _bytes, at);
        }

        public void Write(byte[] values)
        {
            WriteLength(values);
            Bytes(values, 1);
        }

        public void Write(sbyte[] values)
        {
            WriteLength(values);
            Bytes(values, 1);
        }

        public void Write(short[] values)
        {
            WriteLength(values);
            Bytes(values, 2);
        }

        public void Write(ushort[] values)
        {
            WriteLength(values);
            Bytes(values, 2);
        }

        public void Write(int[] values)
        {
            WriteLength(values);
            Bytes(values, 4);
        }

        public void Write(uint[] values)
        {
            WriteLength(values);
            Bytes(values, 4);
        }

        public void Write(float[] values)
        {
            WriteLength(values);
            Bytes(values, 4);
        }

        public void Write(double[] values)
        {
            WriteLength(values);
            Bytes(values, 8);
        }

        public void Write(string[] values)
        {
            WriteLength(values);
            foreach (string value in values) Write(value);
        }

#pragma warning restore 1591

        /// <summary>Writes an array of fixed length, without its length.</summary>
        public void WriteFixed(double[] values, int count)
        {
            if (values == null || values.Length != count)
                throw new ArgumentException($"Expected {count} values, found {values?.Length ?? 0}.", nameof(values));
            Bytes(values, 8);
        }

        /// <summary>Writes the number of messages, then the messages.</summary>
        public void WriteSequence(IMessage[] values)
        {
            WriteLength(values);
            foreach (IMessage value in values) value.Write(this);
        }

        private void WriteLength(Array values)
        {
            if (values == null) throw new ArgumentNullException(nameof(values), "Expected an array in each array field of a message, found null.");
            Write((uint)values.Length);
        }

        /// <summary>Copies values as they are in memory: all of Unity's platforms are little-endian.</summary>
        private void Bytes(Array values, int size)
        {
            if (values.Length == 0) return;
            int count = System.Buffer.ByteLength(values);
            int at = Reserve(count, size);
            System.Buffer.BlockCopy(values, 0, _bytes, at, count);
        }

        private void Put(ulong value, int size)
        {
            int at = Reserve(size, size);
            for (int i = 0; i < size; i++) _bytes[at + i] = (byte)(value >> (8 * i));
        }

        /// <summary>Appends padding and count zero bytes; returns where those bytes begin.</summary>
        private int Reserve(int count, int alignment)
        {
            int padding = Length < HeaderBytes ? 0 : -(Length - HeaderBytes) & (alignment - 1);
            int at = Length + padding;
            int end = checked(at + count);
            if (end > _bytes.Length) Array.Resize(ref _bytes, Math.Max(end, checked(2 * _bytes.Length)));
            Array.Clear(_bytes, Length, end - Length);
            Length = end;
            return at;
        }
    }
}
