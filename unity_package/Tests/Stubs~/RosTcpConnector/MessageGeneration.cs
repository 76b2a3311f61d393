using System;
using System.IO;
using System.Text;

namespace Unity.Robotics.ROSTCPConnector.MessageGeneration
{
    public enum MessageSubtopic
    {
        Default,
        Response,
    }

    public abstract class Message
    {
        public abstract string RosMessageName { get; }

        public abstract void SerializeTo(MessageSerializer serializer);
    }

    public static class MessageRegistry
    {
        private static class Entry<T>
        {
            public static string Name;
            public static Func<MessageDeserializer, Message> Deserialize;
        }

        public static void Register<T>(string name, Func<MessageDeserializer, T> deserialize, MessageSubtopic subtopic = MessageSubtopic.Default)
            where T : Message
        {
            Entry<T>.Name = name;
            Entry<T>.Deserialize = deserialize;
        }

        public static string GetRosMessageName<T>() where T : Message => Entry<T>.Name;

        public static Func<MessageDeserializer, Message> GetDeserializeFunction<T>() where T : Message => Entry<T>.Deserialize;
    }

    /// <summary>Writes CDR after its header, as theirs with the define ROS2.</summary>
    public sealed class MessageSerializer
    {
        private readonly MemoryStream _bytes = new MemoryStream();

        public void Clear() => _bytes.SetLength(0);

        public void SerializeMessage(Message message)
        {
            _bytes.Write(new byte[] { 0, 1, 0, 0 }, 0, 4);
            message.SerializeTo(this);
        }

        public byte[] GetBytes() => _bytes.ToArray();

        public void Write(int value) => Add(BitConverter.GetBytes(value), 4);

        public void Write(double value) => Add(BitConverter.GetBytes(value), 8);

        public void Write(string value)
        {
            byte[] text = Encoding.UTF8.GetBytes(value + "\0");
            Write(text.Length);
            Add(text, 1);
        }

        private void Add(byte[] value, int alignment)
        {
            while ((_bytes.Length - 4) % alignment != 0) _bytes.WriteByte(0);
            _bytes.Write(value, 0, value.Length);
        }
    }

    /// <summary>Reads without a limit but that of the array, as theirs.</summary>
    public sealed class MessageDeserializer
    {
        private byte[] _bytes;
        private int _at;

        public void InitWithBuffer(byte[] data)
        {
            _bytes = data;
            _at = 4;
        }

        public void Read(out int value) => value = BitConverter.ToInt32(_bytes, Next(4));

        public void Read(out double value) => value = BitConverter.ToDouble(_bytes, Next(8));

        public void Read(out string value)
        {
            Read(out int length);
            value = Encoding.UTF8.GetString(_bytes, _at, length - 1);
            _at += length;
        }

        private int Next(int size)
        {
            int start = 4 + (_at - 4 + size - 1) / size * size;
            _at = start + size;
            return start;
        }
    }
}
