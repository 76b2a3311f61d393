namespace Ml2Sensors.Geometry
{
    /// <summary>Directions of x, y and z. Conversions go through REP-103 body axes (FLU).</summary>
    public interface IAxes
    {
        /// <summary>True if the axes are left-handed; those of ROS are right-handed.</summary>
        bool IsLeftHanded { get; }

        /// <summary>Converts components in these axes to a vector in ROS axes.</summary>
        Vector3<Ros> ToRos(double x, double y, double z);

        /// <summary>Converts a vector in ROS axes to components in these axes.</summary>
        void FromRos(in Vector3<Ros> vector, out double x, out double y, out double z);
    }

#pragma warning disable 1591 // Members are those of IAxes.

    /// <summary>REP-103 body: x forward, y left, z up.</summary>
    public struct Ros : IAxes
    {
        public bool IsLeftHanded => false;

        public Vector3<Ros> ToRos(double x, double y, double z) => new Vector3<Ros>(x, y, z);

        public void FromRos(in Vector3<Ros> vector, out double x, out double y, out double z)
        {
            x = vector.X;
            y = vector.Y;
            z = vector.Z;
        }
    }

    /// <summary>REP-103 optical: x right, y down, z forward.</summary>
    public struct Optical : IAxes
    {
        public bool IsLeftHanded => false;

        public Vector3<Ros> ToRos(double x, double y, double z) => new Vector3<Ros>(z, -x, -y);

        public void FromRos(in Vector3<Ros> vector, out double x, out double y, out double z)
        {
            x = -vector.Y;
            y = -vector.Z;
            z = vector.X;
        }
    }

    /// <summary>The headset's interfaces: x right, y up, z backward.</summary>
    public struct MlRub : IAxes
    {
        public bool IsLeftHanded => false;

        public Vector3<Ros> ToRos(double x, double y, double z) => new Vector3<Ros>(-z, -x, y);

        public void FromRos(in Vector3<Ros> vector, out double x, out double y, out double z)
        {
            x = -vector.Y;
            y = vector.Z;
            z = -vector.X;
        }
    }

    /// <summary>Unity: x right, y up, z forward, left-handed.</summary>
    public struct UnitySpace : IAxes
    {
        public bool IsLeftHanded => true;

        public Vector3<Ros> ToRos(double x, double y, double z) => new Vector3<Ros>(z, -x, y);

        public void FromRos(in Vector3<Ros> vector, out double x, out double y, out double z)
        {
            x = -vector.Y;
            y = vector.Z;
            z = vector.X;
        }
    }
}
