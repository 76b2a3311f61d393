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

    /// <summary>A message that begins with a header, whose stamp Ml2Publisher writes.</summary>
    public interface IStamped
    {
        /// <summary>The header that the message begins with.</summary>
        HeaderMsg Header { get; }
    }
}
