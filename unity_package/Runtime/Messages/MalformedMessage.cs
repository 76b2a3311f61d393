using System;
using System.Text;

namespace Ml2Sensors.Messages
{
    /// <summary>The first thing in a payload that is not as its type says.</summary>
    public sealed class MalformedMessage
    {
        internal MalformedMessage(string field, int offset, string expected, string found)
        {
            Field = field;
            Offset = offset;
            Expected = expected;
            Found = found;
        }

        /// <summary>The field's path, such as "poses[2].position.x"; empty for the payload as a whole.</summary>
        public string Field { get; }

        /// <summary>The index of the byte, counted from the start of the payload.</summary>
        public int Offset { get; }

        /// <summary>The value or layout that the type requires there.</summary>
        public string Expected { get; }

        /// <summary>The content that the payload has there.</summary>
        public string Found { get; }

        /// <summary>A sentence with all of it.</summary>
        public override string ToString() => $"{(Field == "" ? "message" : Field)} at byte {Offset}: expected {Expected}, found {Found}";
    }

    /// <summary>The way from a message to a field of a message within it. Grows to the greatest depth, and is used again.</summary>
    internal sealed class FieldPath
    {
        private string[] _fields = new string[8];
        private int[] _indexes = new int[8];
        private int _depth;

        /// <summary>The index in the array that was entered last.</summary>
        public int Index
        {
            set => _indexes[_depth - 1] = value;
        }

        public void Clear() => _depth = 0;

        public void Enter(string field)
        {
            if (_depth == _fields.Length)
            {
                Array.Resize(ref _fields, 2 * _depth);
                Array.Resize(ref _indexes, 2 * _depth);
            }
            _fields[_depth] = field;
            _indexes[_depth++] = -1;
        }

        public void Leave() => _depth--;

        /// <summary>The path of a field of the message that was entered last; "" is the element that was.</summary>
        public string Of(string field)
        {
            var path = new StringBuilder();
            for (int i = 0; i < _depth; i++)
            {
                path.Append(i == 0 ? "" : ".").Append(_fields[i]);
                if (_indexes[i] >= 0) path.Append('[').Append(_indexes[i]).Append(']');
            }
            return path.Append(_depth > 0 && field != "" ? "." : "").Append(field).ToString();
        }
    }

    internal static class Utf8
    {
        /// <summary>Decodes bytes without garbage.</summary>
        /// <param name="count">The number of units; or where the bytes are not UTF-8, or a NUL, counted from the start.</param>
        public static bool TryDecode(byte[] bytes, int start, int end, char[] text, out int count)
        {
            count = 0;
            for (int at = start; at < end;)
            {
                int first = bytes[at], more = first < 0x80 ? 0 : first < 0xc2 ? 4 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : first < 0xf5 ? 3 : 4;
                int point = more == 0 ? first : first & (0x3f >> more);
                bool isWhole = more < 4 && at + more < end && first != 0;
                for (int i = 1; i <= more && isWhole; i++)
                {
                    isWhole = (bytes[at + i] & 0xc0) == 0x80;
                    point = (point << 6) | (bytes[at + i] & 0x3f);
                }
                bool isShortest = more < 2 || point >= (more == 2 ? 0x800 : 0x10000);
                if (!isWhole || !isShortest || point > 0x10ffff || (point >= 0xd800 && point < 0xe000))
                {
                    count = at - start;
                    return false;
                }
                if (point >= 0x10000)
                {
                    text[count++] = (char)(0xd7c0 + (point >> 10));
                    text[count++] = (char)(0xdc00 | (point & 0x3ff));
                }
                else text[count++] = (char)point;
                at += 1 + more;
            }
            return true;
        }

        /// <summary>The index of half a surrogate pair; -1 if there is none.</summary>
        public static int UnpairedSurrogate(char[] text, int count)
        {
            for (int i = 0; i < count; i++)
            {
                if (!char.IsSurrogate(text[i])) continue;
                if (i + 1 == count || !char.IsSurrogatePair(text[i], text[i + 1])) return i;
                i++;
            }
            return -1;
        }
    }
}
