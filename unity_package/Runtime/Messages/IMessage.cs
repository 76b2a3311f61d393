namespace Ml2Sensors.Messages
{
    /// <summary>A ROS 2 message. Fields have the names that ROS gives them.</summary>
    public interface IMessage
    {
        /// <summary>The ROS type, such as "sensor_msgs/msg/Imu".</summary>
        string RosType { get; }

        /// <summary>Appends the fields in their order.</summary>
        void Write(CdrWriter cdr);
    }

    /// <summary>A message that can be received, too.</summary>
    public interface IReadable : IMessage
    {
        /// <summary>The hash of the type (REP-2016), by which a receiver knows whether it has the same one.</summary>
        string RosHash { get; }

        /// <summary>Replaces the fields in their order. What CdrReader.Error tells of is not read.</summary>
        void Read(CdrReader cdr);
    }

    /// <summary>A message that begins with a header, whose stamp Ml2Publisher writes.</summary>
    public interface IStamped
    {
        /// <summary>The header that the message begins with.</summary>
        HeaderMsg Header { get; }
    }
}
