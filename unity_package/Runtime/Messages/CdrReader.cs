using System;

namespace Ml2Sensors.Messages
{
    /// <summary>
    /// Decodes messages from plain little-endian CDR. Every length is compared with the bytes that are there before anything
    /// is allocated. Arrays and texts of a message are used again, so reading a message of the same lengths and texts into
    /// the same object allocates nothing. Malformed bytes raise no exception: Error tells of the first, and nothing after it is
    /// read. Not thread-safe.
    /// </summary>
    public sealed class CdrReader
    {
        private const int HeaderBytes = 4;
        private readonly FieldPath _path = new FieldPath();
        private char[] _text = new char[64];
        private byte[] _bytes;
        private int _at, _end;

        /// <summary>The first error of the last payload; null if it is well-formed.</summary>
        public MalformedMessage Error { get; private set; }

        /// <summary>
        /// Replaces the fields of a message by those in a payload. Bytes after the message are ignored: writers of ROS may leave
        /// some there.
        /// </summary>
        /// <param name="payload">A message as CDR, encapsulation header included, from the start.</param>
        /// <returns>False if the payload is malformed: Error says how, and the message has some of its fields.</returns>
        /// <exception cref="ArgumentException">The array is shorter than the length.</exception>
        public bool TryReadPayload(byte[] payload, int length, IReadable message)
        {
            if (length < 0 || length > payload.Length)
                throw new ArgumentException($"Expected 0 to {payload.Length} bytes, found {length}.", nameof(length));
            _bytes = payload;
            _at = 0;
            _end = length;
            _path.Clear();
            Error = null;
            if (length < HeaderBytes || payload[0] != 0 || payload[1] != 1)
                Fail("", "encapsulation 00 01", BitConverter.ToString(payload, 0, Math.Min(length, 2)).Replace('-', ' '), 0);
            else _at = HeaderBytes;
            message.Read(this);
            _bytes = null;
            return Error == null;
        }

#pragma warning disable 1591 // One for each type of a field.
        public void Read(ref bool value, string field)
        {
            if (!Reserve(1, 1, field)) return;
            if (_bytes[_at] > 1) Fail(field, "bool of 0 or 1", _bytes[_at].ToString(), _at);
            else value = _bytes[_at++] == 1;
        }

        public void Read(ref sbyte value, string field) => value = (sbyte)Number(1, field, (byte)value);

        public void Read(ref byte value, string field) => value = (byte)Number(1, field, value);

        public void Read(ref short value, string field) => value = (short)Number(2, field, (ushort)value);

        public void Read(ref ushort value, string field) => value = (ushort)Number(2, field, value);

        public void Read(ref int value, string field) => value = (int)Number(4, field, (uint)value);

        public void Read(ref uint value, string field) => value = (uint)Number(4, field, value);

        public void Read(ref long value, string field) => value = (long)Number(8, field, (ulong)value);

        public void Read(ref ulong value, string field) => value = Number(8, field, value);

        public unsafe void Read(ref float value, string field)
        {
            float now = value;
            uint bits = (uint)Number(4, field, *(uint*)&now);
            value = *(float*)&bits;
        }

        public void Read(ref double value, string field) =>
            value = BitConverter.Int64BitsToDouble((long)Number(8, field, (ulong)BitConverter.DoubleToInt64Bits(value)));

        public void Read(ref string value, string field, int mostBytes = int.MaxValue)
        {
            int size = Length(1, mostBytes == int.MaxValue ? mostBytes : mostBytes + 1, field);
            if (Error != null) return;
            int start = _at, last = _at + size - 1;
            if (size == 0) Fail(field, "a text with the NUL that ends it", "size 0", start - 4);
            else if (_bytes[last] != 0) Fail(field, "NUL", "0x" + _bytes[last].ToString("x2"), last);
            else if (!Utf8.TryDecode(_bytes, start, last, Text(size), out int count)) Fail(field, "UTF-8 without NUL", "other bytes", start + count);
            else Keep(ref value, count);
            if (Error == null) _at = start + size;
        }

        public void ReadWide(ref string value, string field, int mostUnits = int.MaxValue)
        {
            int count = Length(4, mostUnits, field);
            char[] text = Text(count);
            for (int i = 0; i < count && Error == null; i++)
            {
                ulong unit = Number(4, field, 0);
                text[i] = (char)unit;
                if (unit > char.MaxValue) Fail(field, "UTF-16", "0x" + unit.ToString("x8"), _at - 4);
            }
            int half = Error == null ? Utf8.UnpairedSurrogate(text, count) : -1;
            if (half >= 0)
                Fail(field, "UTF-16", "half a surrogate pair", _at - 4 * (count - half));
            if (Error == null) Keep(ref value, count);
        }

        public void ReadTexts(ref string[] values, string field, int most = int.MaxValue, int mostBytes = int.MaxValue) =>
            FillTexts(ref values, Length(5, most, field), field, mostBytes, false);

        public void ReadFixedTexts(ref string[] values, string field, int count, int mostBytes = int.MaxValue) =>
            FillTexts(ref values, count, field, mostBytes, false);

        public void ReadWideTexts(ref string[] values, string field, int most = int.MaxValue, int mostUnits = int.MaxValue) =>
            FillTexts(ref values, Length(4, most, field), field, mostUnits, true);

        public void ReadFixedWideTexts(ref string[] values, string field, int count, int mostUnits = int.MaxValue) =>
            FillTexts(ref values, count, field, mostUnits, true);

        public void ReadMessage<T>(ref T value, string field) where T : class, IReadable, new()
        {
            if (Error != null) return;
            _path.Enter(field);
            if (value == null) value = new T();
            value.Read(this);
            _path.Leave();
        }

        /// <summary>Reads the byte that stands for a message without fields.</summary>
        public void ReadEmpty() => Number(1, "", 0);

#pragma warning restore 1591

        /// <summary>Reads a number of values, then the values. Makes another array only if the length is another.</summary>
        /// <typeparam name="T">bool, or a type of numbers.</typeparam>
        public void Read<T>(ref T[] values, string field, int most = int.MaxValue) where T : struct =>
            Fill(ref values, Length(SizeOf<T>.Value, most, field), field);

        /// <summary>Reads an array of fixed length.</summary>
        /// <typeparam name="T">bool, or a type of numbers.</typeparam>
        public void ReadFixed<T>(ref T[] values, string field, int count) where T : struct => Fill(ref values, count, field);

        /// <summary>Reads a number of messages, then the messages. Those that the array has are used again.</summary>
        /// <param name="leastSize">The fewest bytes that a message takes, padding aside.</param>
        public void ReadSequence<T>(ref T[] values, string field, int leastSize, int most = int.MaxValue)
            where T : class, IReadable, new() => ReadMessages(ref values, field, Length(leastSize, most, field));

        /// <summary>Reads messages in an array of fixed length.</summary>
        public void ReadMessages<T>(ref T[] values, string field, int count) where T : class, IReadable, new()
        {
            if (Error != null) return;
            if (values == null || values.Length != count) Array.Resize(ref values, count);
            _path.Enter(field);
            for (int i = 0; i < count && Error == null; i++)
            {
                _path.Index = i;
                if (values[i] == null) values[i] = new T();
                values[i].Read(this);
            }
            _path.Leave();
            if (Error == null) return;
            for (int i = 0; i < count; i++) if (values[i] == null) values[i] = new T();
        }

        private void FillTexts(ref string[] values, int count, string field, int most, bool isWide)
        {
            if (Error != null) return;
            if (values == null || values.Length != count) Array.Resize(ref values, count);
            _path.Enter(field);
            for (int i = 0; i < count; i++)
            {
                _path.Index = i;
                if (isWide) ReadWide(ref values[i], "", most);
                else Read(ref values[i], "", most);
                if (values[i] == null) values[i] = "";
            }
            _path.Leave();
        }

        private void Fill<T>(ref T[] values, int count, string field) where T : struct
        {
            int size = SizeOf<T>.Value;
            if (count > 0 ? !Reserve((long)count * size, size, field) : Error != null) return;
            if (typeof(T) == typeof(bool))
                for (int i = _at; i < _at + count; i++)
                    if (_bytes[i] > 1)
                    {
                        Fail(field, "bools of 0 or 1", _bytes[i].ToString(), i);
                        return;
                    }
            if (values == null || values.Length != count) values = new T[count];
            Buffer.BlockCopy(_bytes, _at, values, 0, count * size);
            _at += count * size;
        }

        /// <summary>Reads a number of elements, of which the payload has the bytes; 0 if it does not.</summary>
        private int Length(int leastSize, int most, string field)
        {
            ulong count = Number(4, field, 0);
            if (Error != null) return 0;
            int room = (_end - _at) / leastSize;
            if (count <= (ulong)Math.Min(room, most)) return (int)count;
            Fail(field, most < room ? $"a length of at most {most}" : $"a length of at most {room} in {_end - _at} bytes", count.ToString(), _at - 4);
            return 0;
        }

        private ulong Number(int size, string field, ulong otherwise)
        {
            if (!Reserve(size, size, field)) return otherwise;
            ulong value = 0;
            for (int i = 0; i < size; i++) value |= (ulong)_bytes[_at + i] << (8 * i);
            _at += size;
            return value;
        }

        /// <summary>Skips padding; returns false if so many bytes do not follow.</summary>
        private bool Reserve(long count, int alignment, string field)
        {
            if (Error != null) return false;
            int padding = -(_at - HeaderBytes) & (alignment - 1);
            if (padding + count <= _end - _at)
            {
                _at += padding;
                return true;
            }
            Fail(field, $"{padding + count} bytes", (_end - _at).ToString(), _at);
            return false;
        }

        private char[] Text(int count)
        {
            if (_text.Length < count) _text = new char[count];
            return _text;
        }

        private void Keep(ref string value, int count)
        {
            bool isSame = value != null && value.Length == count;
            for (int i = 0; i < count && isSame; i++) isSame = value[i] == _text[i];
            if (!isSame) value = new string(_text, 0, count);
        }

        private void Fail(string field, string expected, string found, int offset)
        {
            if (Error == null) Error = new MalformedMessage(_path.Of(field), offset, expected, found);
        }

        private static class SizeOf<T>
        {
            public static readonly int Value = Buffer.ByteLength(new T[1]);
        }
    }
}
