using UnityEngine;

namespace Ml2Sensors.Geometry
{
    /// <summary>Conversions between axes. Functions are pure and allocate nothing.</summary>
    public static class Conversions
    {
        /// <summary>The rotation of an optical frame in the body frame of the same camera (REP-103, suffix frames).</summary>
        public static readonly Rotation<Ros> OpticalInBody = new Rotation<Ros>(-0.5, 0.5, -0.5, 0.5);

        /// <summary>Converts to the axes of REP-103 bodies.</summary>
        public static Vector3<Ros> ToRos<TAxes>(this in Vector3<TAxes> v) where TAxes : struct, IAxes =>
            default(TAxes).ToRos(v.X, v.Y, v.Z);

        /// <summary>Converts to the axes of the headset's interfaces.</summary>
        public static Vector3<MlRub> ToMl<TAxes>(this in Vector3<TAxes> v) where TAxes : struct, IAxes => Convert<TAxes, MlRub>(v);

        /// <summary>Converts to the axes of REP-103 cameras.</summary>
        public static Vector3<Optical> ToOptical<TAxes>(this in Vector3<TAxes> v) where TAxes : struct, IAxes =>
            Convert<TAxes, Optical>(v);

        /// <summary>Converts to Unity's axes.</summary>
        public static Vector3<UnitySpace> ToUnity<TAxes>(this in Vector3<TAxes> v) where TAxes : struct, IAxes =>
            Convert<TAxes, UnitySpace>(v);

        /// <summary>Converts to the axes of REP-103 bodies and normalises.</summary>
        public static Rotation<Ros> ToRos<TAxes>(this in Rotation<TAxes> q) where TAxes : struct, IAxes => Convert<TAxes, Ros>(q);

        /// <summary>Converts to Unity's axes and normalises.</summary>
        public static Rotation<UnitySpace> ToUnity<TAxes>(this in Rotation<TAxes> q) where TAxes : struct, IAxes =>
            Convert<TAxes, UnitySpace>(q);

        /// <summary>Converts to the axes of REP-103 bodies.</summary>
        public static Pose<Ros> ToRos<TAxes>(this in Pose<TAxes> pose) where TAxes : struct, IAxes =>
            new Pose<Ros>(pose.Position.ToRos(), pose.Rotation.ToRos());

        /// <summary>Converts to Unity's axes.</summary>
        public static Pose<UnitySpace> ToUnity<TAxes>(this in Pose<TAxes> pose) where TAxes : struct, IAxes =>
            new Pose<UnitySpace>(pose.Position.ToUnity(), pose.Rotation.ToUnity());

        /// <summary>Returns the pose of a camera's optical frame in a world with ROS axes, as on /tf.</summary>
        public static Pose<Ros> ToOpticalFrame<TAxes>(this in Pose<TAxes> camera) where TAxes : struct, IAxes
        {
            Pose<Ros> body = camera.ToRos();
            return new Pose<Ros>(body.Position, body.Rotation * OpticalInBody);
        }

        private static Vector3<TTo> Convert<TFrom, TTo>(in Vector3<TFrom> v) where TFrom : struct, IAxes where TTo : struct, IAxes
        {
            default(TTo).FromRos(v.ToRos(), out double x, out double y, out double z);
            return new Vector3<TTo>(x, y, z);
        }

        /// <summary>Converts the axis as a vector, and reverses the angle if the handedness changes.</summary>
        private static Rotation<TTo> Convert<TFrom, TTo>(in Rotation<TFrom> q) where TFrom : struct, IAxes where TTo : struct, IAxes
        {
            var axis = Convert<TFrom, TTo>(new Vector3<TFrom>(q.X, q.Y, q.Z));
            double sense = default(TFrom).IsLeftHanded == default(TTo).IsLeftHanded ? 1 : -1;
            return new Rotation<TTo>(sense * axis.X, sense * axis.Y, sense * axis.Z, q.W).Normalized();
        }
    }

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
