namespace Ml2Sensors.Messages
{
    /// <summary>A ROS 2 message; fields have the names that ROS gives them.</summary>
    public interface IMessage
    {
        /// <summary>Such as "sensor_msgs/msg/Imu".</summary>
        string RosType { get; }

        /// <summary>Appends the fields in their order.</summary>
        void Write(CdrWriter cdr);
    }
}
