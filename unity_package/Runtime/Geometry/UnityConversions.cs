using UnityEngine;

namespace Ml2Sensors.Geometry
{
    /// <summary>Conversions to and from Unity's own types, which have Unity's axes.</summary>
    public static class UnityConversions
    {
        /// <summary>Converts to Unity's type, in single precision.</summary>
        public static Vector3 ToVector3(this in Vector3<UnitySpace> v) => new Vector3((float)v.X, (float)v.Y, (float)v.Z);

        /// <summary>Converts to Unity's type, in single precision.</summary>
        public static Quaternion ToQuaternion(this in Rotation<UnitySpace> q) =>
            new Quaternion((float)q.X, (float)q.Y, (float)q.Z, (float)q.W);

        /// <summary>Converts to Unity's type, in single precision.</summary>
        public static Pose ToPose(this in Pose<UnitySpace> pose) => new Pose(pose.Position.ToVector3(), pose.Rotation.ToQuaternion());

        /// <summary>Converts from Unity's type.</summary>
        public static Vector3<UnitySpace> InUnity(this Vector3 v) => new Vector3<UnitySpace>(v.x, v.y, v.z);

        /// <summary>Converts from Unity's type.</summary>
        public static Rotation<UnitySpace> InUnity(this Quaternion q) => new Rotation<UnitySpace>(q.x, q.y, q.z, q.w);
    }
}
