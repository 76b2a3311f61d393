using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using Ml2Sensors.Messages;
using Newtonsoft.Json.Linq;
using NUnit.Framework;

namespace Ml2Sensors.Tests
{
    /// <summary>
    /// Compares messages with the bytes in tests/conformance/vectors/cdr, which all languages read. Other types are those of
    /// tests/unity/test_csharp_messages.py.
    /// </summary>
    [TestFixture]
    public sealed class CdrVectorTests
    {
        public static IEnumerable<TestCaseData> Cases =>
            Directory.GetFiles(Path.Combine(Environment.GetEnvironmentVariable("ML2_VECTORS"), "cdr"), "*.json")
                .SelectMany(path => Read(path).Properties())
                .Select(vector => new TestCaseData((JObject)vector.Value).SetName(vector.Name));

        private static JObject Read(string path) =>
            JObject.Parse(File.ReadAllText(path).Replace(": -0.0,", ": \"-0.0\",")); // mono would read a plain 0

        [Test]
        [TestCaseSource("Cases")]
        public void WritePayload_Vector_IsItsBytes(JObject vector)
        {
            IMessage message = MessageOf((string)vector["type"]);
            Fill(message, (JObject)vector["message"]);
            var cdr = new CdrWriter();
            cdr.WritePayload(new ImageMsg { data = Enumerable.Repeat((byte)255, 5000).ToArray() }); // a buffer that was used
            cdr.WritePayload(message);
            Assert.AreEqual(vector["bytes"].SelectMany(Piece).ToArray(), cdr.Buffer.Take(cdr.Length).ToArray());
        }

        [Test]
        [TestCaseSource("Cases")]
        public void TryReadPayload_Vector_IsTheMessage(JObject vector)
        {
            byte[] bytes = vector["bytes"].SelectMany(Piece).ToArray();
            IMessage message = MessageOf((string)vector["type"]);
            var reader = new CdrReader();
            Assert.IsTrue(reader.TryReadPayload(bytes, bytes.Length, (IReadable)message), $"{reader.Error}");
            var cdr = new CdrWriter();
            cdr.WritePayload(message);
            Assert.AreEqual(bytes, cdr.Buffer.Take(cdr.Length).ToArray());
        }

        [Test]
        public void WritePayload_SameMessageAgain_MakesNoGarbage()
        {
            var cdr = new CdrWriter();
            var imu = new ImuMsg();
            imu.header.frame_id = "imu_left_frame";
            cdr.WritePayload(imu);
            long before = GC.GetAllocatedBytesForCurrentThread();
            for (int i = 0; i < 1000; i++) cdr.WritePayload(imu);
            Assert.AreEqual(0, GC.GetAllocatedBytesForCurrentThread() - before);
        }

        [Test]
        public void WritePayload_ArrayOfAnotherLength_Throws()
        {
            var imu = new ImuMsg { orientation_covariance = new double[8] };
            Assert.Throws<ArgumentException>(() => new CdrWriter().WritePayload(imu));
        }

        [Test]
        public void WritePayload_HalfASurrogatePair_Throws()
        {
            Assert.Catch<ArgumentException>(() => new CdrWriter().WritePayload(new StringMsg { data = "\ud800" }));
        }

        /// <summary>Bytes of a piece as tests/conformance/README.md describes it: a pattern or hexadecimal.</summary>
        private static IEnumerable<byte> Piece(JToken piece)
        {
            if (piece["pattern"] != null) return Pattern((int)piece["length"]);
            string hex = ((string)piece["hex"]).Replace(" ", "");
            return Enumerable.Range(0, hex.Length / 2).Select(i => Convert.ToByte(hex.Substring(2 * i, 2), 16));
        }

        private static IEnumerable<byte> Pattern(int length) => Enumerable.Range(0, length).Select(i => (byte)(i % 251));

        /// <summary>The bits of the vectors: .NET's own NaN is the negative one.</summary>
        private static double NoNumber(string text)
        {
            if (text == "NaN") return BitConverter.Int64BitsToDouble(0x7ff8000000000000);
            if (text == "-0.0") return BitConverter.Int64BitsToDouble(long.MinValue);
            return text == "Infinity" ? double.PositiveInfinity : double.NegativeInfinity;
        }

        private static IMessage MessageOf(string rosType) =>
            typeof(IMessage).Assembly.GetTypes().Where(type => typeof(IMessage).IsAssignableFrom(type) && type.IsClass)
                .Select(type => (IMessage)Activator.CreateInstance(type)).Single(message => message.RosType == rosType);

        private static void Fill(object message, JObject values)
        {
            foreach (JProperty value in values.Properties())
            {
                FieldInfo field = message.GetType().GetField(value.Name);
                Assert.IsNotNull(field, value.Name);
                field.SetValue(message, ValueOf(value.Value, field.FieldType));
            }
        }

        private static object ValueOf(JToken token, Type type)
        {
            if (type == typeof(byte[]) && token is JObject)
                return Pattern((int)token["length"]).ToArray();
            if (type.IsArray)
            {
                Array array = Array.CreateInstance(type.GetElementType(), token.Count());
                for (int i = 0; i < array.Length; i++) array.SetValue(ValueOf(token[i], type.GetElementType()), i);
                return array;
            }
            if (token.Type == JTokenType.String && type != typeof(string)) return Convert.ChangeType(NoNumber((string)token), type);
            if (!typeof(IMessage).IsAssignableFrom(type)) return token.ToObject(type);
            object message = Activator.CreateInstance(type);
            Fill(message, (JObject)token);
            return message;
        }
    }
}
