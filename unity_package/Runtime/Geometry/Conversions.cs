namespace Ml2Sensors.Geometry
{
    /// <summary>The same thing in other axes. Pure functions; nothing is allocated.</summary>
    public static class Conversions
    {
        /// <summary>An optical frame in the body frame of the same camera. Source: REP-103, suffix frames.</summary>
        public static readonly Rotation<Ros> OpticalInBody = new Rotation<Ros>(-0.5, 0.5, -0.5, 0.5);

        /// <summary>In the axes of REP-103 bodies.</summary>
        public static Vector3<Ros> ToRos<TAxes>(this in Vector3<TAxes> v) where TAxes : struct, IAxes =>
            default(TAxes).ToRos(v.X, v.Y, v.Z);

        /// <summary>In the axes of the headset's interfaces.</summary>
        public static Vector3<MlRub> ToMl<TAxes>(this in Vector3<TAxes> v) where TAxes : struct, IAxes => Convert<TAxes, MlRub>(v);

        /// <summary>In the axes of REP-103 cameras.</summary>
        public static Vector3<Optical> ToOptical<TAxes>(this in Vector3<TAxes> v) where TAxes : struct, IAxes =>
            Convert<TAxes, Optical>(v);

        /// <summary>In Unity's axes.</summary>
        public static Vector3<UnitySpace> ToUnity<TAxes>(this in Vector3<TAxes> v) where TAxes : struct, IAxes =>
            Convert<TAxes, UnitySpace>(v);

        /// <summary>In the axes of REP-103 bodies, normalised.</summary>
        public static Rotation<Ros> ToRos<TAxes>(this in Rotation<TAxes> q) where TAxes : struct, IAxes => Convert<TAxes, Ros>(q);

        /// <summary>In Unity's axes, normalised.</summary>
        public static Rotation<UnitySpace> ToUnity<TAxes>(this in Rotation<TAxes> q) where TAxes : struct, IAxes =>
            Convert<TAxes, UnitySpace>(q);

        /// <summary>In the axes of REP-103 bodies.</summary>
        public static Pose<Ros> ToRos<TAxes>(this in Pose<TAxes> pose) where TAxes : struct, IAxes =>
            new Pose<Ros>(pose.Position.ToRos(), pose.Rotation.ToRos());

        /// <summary>In Unity's axes.</summary>
        public static Pose<UnitySpace> ToUnity<TAxes>(this in Pose<TAxes> pose) where TAxes : struct, IAxes =>
            new Pose<UnitySpace>(pose.Position.ToUnity(), pose.Rotation.ToUnity());

        /// <summary>As on /tf: a camera's optical frame in a world with the axes of ROS.</summary>
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

        /// <summary>The axis is a vector; the angle changes its sense with the handedness.</summary>
        private static Rotation<TTo> Convert<TFrom, TTo>(in Rotation<TFrom> q) where TFrom : struct, IAxes where TTo : struct, IAxes
        {
            var axis = Convert<TFrom, TTo>(new Vector3<TFrom>(q.X, q.Y, q.Z));
            double sense = default(TFrom).IsLeftHanded == default(TTo).IsLeftHanded ? 1 : -1;
            return new Rotation<TTo>(sense * axis.X, sense * axis.Y, sense * axis.Z, q.W).Normalized();
        }
    }
}
