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

        public void Write(string value, int mostBytes = int.MaxValue)
        {
            if (value == null) throw new ArgumentNullException(nameof(value), "Expected a string in each string field of a message, found null.");
            if (value.IndexOf('\0') >= 0) throw new ArgumentException("Expected text without NUL.", nameof(value));
            int count = Utf8.GetByteCount(value);
            if (count > mostBytes) throw new ArgumentException($"Expected text of at most {mostBytes} bytes of UTF-8, found {count}.", nameof(value));
            Write((uint)count + 1);
            int at = Reserve(count + 1, 1);
            Utf8.GetBytes(value, 0, value.Length, _bytes, at);
        }

        public void Write(string[] values) => WriteTexts(values);

        public void WriteTexts(string[] values, int most = int.MaxValue, int mostBytes = int.MaxValue)
        {
            WriteLength(values, most);
            foreach (string value in values) Write(value, mostBytes);
        }

        public void WriteFixedTexts(string[] values, int count, int mostBytes = int.MaxValue)
        {
            CheckLength(values, count);
            foreach (string value in values) Write(value, mostBytes);
        }

        public void WriteWide(string value, int mostUnits = int.MaxValue)
        {
            if (value == null) throw new ArgumentNullException(nameof(value), "Expected a string in each string field of a message, found null.");
            if (value.Length > mostUnits) throw new ArgumentException($"Expected text of at most {mostUnits} units, found {value.Length}.", nameof(value));
            Utf8.GetByteCount(value); // throws for half a surrogate pair
            Write((uint)value.Length);
            foreach (char unit in value) Write((uint)unit);
        }

        public void WriteWideTexts(string[] values, int most = int.MaxValue, int mostUnits = int.MaxValue)
        {
            WriteLength(values, most);
            foreach (string value in values) WriteWide(value, mostUnits);
        }

        public void WriteFixedWideTexts(string[] values, int count, int mostUnits = int.MaxValue)
        {
            CheckLength(values, count);
            foreach (string value in values) WriteWide(value, mostUnits);
        }

        public void WriteMessage(IMessage value)
        {
            if (value == null) throw new ArgumentNullException(nameof(value), "Expected a message in each message field of a message, found null.");
            value.Write(this);
        }

        /// <summary>Writes the byte that stands for a message without fields.</summary>
        public void WriteEmpty() => Write((byte)0);

#pragma warning restore 1591

        /// <summary>Writes the number of values, then the values.</summary>
        /// <typeparam name="T">bool, or a type of numbers.</typeparam>
        public void Write<T>(T[] values, int most = int.MaxValue) where T : struct
        {
            WriteLength(values, most);
            Bytes(values);
        }

        /// <summary>Writes an array of fixed length, without its length.</summary>
        /// <typeparam name="T">bool, or a type of numbers.</typeparam>
        public void WriteFixed<T>(T[] values, int count) where T : struct
        {
            CheckLength(values, count);
            Bytes(values);
        }

        /// <summary>Writes the number of messages, then the messages.</summary>
        public void WriteSequence(IMessage[] values, int most = int.MaxValue)
        {
            WriteLength(values, most);
            foreach (IMessage value in values) WriteMessage(value);
        }

        /// <summary>Writes messages in an array of fixed length, without its length.</summary>
        public void WriteMessages(IMessage[] values, int count)
        {
            CheckLength(values, count);
            foreach (IMessage value in values) WriteMessage(value);
        }

        private void WriteLength(Array values, int most)
        {
            if (values == null) throw new ArgumentNullException(nameof(values), "Expected an array in each array field of a message, found null.");
            if (values.Length > most) throw new ArgumentException($"Expected at most {most} values, found {values.Length}.", nameof(values));
            Write((uint)values.Length);
        }

        private static void CheckLength(Array values, int count)
        {
            if (values == null || values.Length != count)
                throw new ArgumentException($"Expected {count} values, found {values?.Length ?? 0}.", nameof(values));
        }

        /// <summary>Copies values as they are in memory: all of Unity's platforms are little-endian.</summary>
        private void Bytes(Array values)
        {
            if (values.Length == 0) return;
            int count = System.Buffer.ByteLength(values);
            int at = Reserve(count, count / values.Length);
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
