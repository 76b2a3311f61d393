using System;
using System.Linq;
using Ml2Sensors.Messages;

/// <summary>
/// Reads and writes messages for test_csharp_messages.py. Each line of the input is a type and a payload. The answer is the
/// payload that the message writes, and how many bytes a second read into the same object allocated; or what is malformed.
/// Without a payload, the answer is that of a new message.
/// </summary>
internal static class Exchange
{
    private const int Reads = 20;

    private static void Main()
    {
        var types = typeof(IReadable).Assembly.GetTypes().Where(type => typeof(IReadable).IsAssignableFrom(type) && type.IsClass)
            .ToDictionary(type => ((IReadable)Activator.CreateInstance(type)).RosType);
        var reader = new CdrReader();
        var writer = new CdrWriter();
        for (string line = Console.ReadLine(); line != null; line = Console.ReadLine())
        {
            string[] words = line.Split(' ');
            var message = (IReadable)Activator.CreateInstance(types[words[0]]);
            byte[] payload = words.Length == 1 ? null : Bytes(words[1]);
            Console.WriteLine(payload == null ? Written(writer, message) : Answer(reader, writer, message, payload));
            Console.Out.Flush();
        }
    }

    private static byte[] Bytes(string hex) =>
        Enumerable.Range(0, hex.Length / 2).Select(i => Convert.ToByte(hex.Substring(2 * i, 2), 16)).ToArray();

    private static string Answer(CdrReader reader, CdrWriter writer, IReadable message, byte[] payload)
    {
        if (!reader.TryReadPayload(payload, payload.Length, message))
        {
            writer.WritePayload(message); // which still has a value in each field
            return $"malformed {reader.Error.Offset} {reader.Error}";
        }
        long before = GC.GetAllocatedBytesForCurrentThread();
        for (int i = 0; i < Reads; i++) reader.TryReadPayload(payload, payload.Length, message);
        long allocated = GC.GetAllocatedBytesForCurrentThread() - before;
        return $"{Written(writer, message)} {allocated}";
    }

    private static string Written(CdrWriter writer, IMessage message)
    {
        writer.WritePayload(message);
        return BitConverter.ToString(writer.Buffer, 0, writer.Length).Replace("-", "").ToLowerInvariant();
    }
}
