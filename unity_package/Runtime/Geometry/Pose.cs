using System;

namespace Ml2Sensors.Geometry
{
    /// <summary>A vector whose type states its axes, so that vectors in different axes cannot be mixed.</summary>
    public readonly struct Vector3<TAxes> where TAxes : struct
    {
        /// <summary>Along the first axis.</summary>
        public readonly double X;

        /// <summary>Along the second axis.</summary>
        public readonly double Y;

        /// <summary>Along the third axis.</summary>
        public readonly double Z;

        /// <summary>Creates a vector in the axes of its type.</summary>
        public Vector3(double x, double y, double z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        /// <summary>Adds two vectors.</summary>
        public static Vector3<TAxes> operator +(in Vector3<TAxes> a, in Vector3<TAxes> b) =>
            new Vector3<TAxes>(a.X + b.X, a.Y + b.Y, a.Z + b.Z);

        /// <summary>Subtracts b from a.</summary>
        public static Vector3<TAxes> operator -(in Vector3<TAxes> a, in Vector3<TAxes> b) =>
            new Vector3<TAxes>(a.X - b.X, a.Y - b.Y, a.Z - b.Z);

        /// <summary>Scales a vector.</summary>
        public static Vector3<TAxes> operator *(double scale, in Vector3<TAxes> vector) =>
            new Vector3<TAxes>(scale * vector.X, scale * vector.Y, scale * vector.Z);

        /// <summary>Returns components and axes as text.</summary>
        public override string ToString() => $"({X}, {Y}, {Z}) {typeof(TAxes).Name}";
    }

    /// <summary>The rotation of an object in the world, as a quaternion. Both have the axes of the type.</summary>
    public readonly struct Rotation<TAxes> where TAxes : struct
    {
        /// <summary>The first component of the vector part.</summary>
        public readonly double X;

        /// <summary>The second component of the vector part.</summary>
        public readonly double Y;

        /// <summary>The third component of the vector part.</summary>
        public readonly double Z;

        /// <summary>The scalar part.</summary>
        public readonly double W;

        /// <summary>Creates a rotation; the quaternion need not be normalised.</summary>
        public Rotation(double x, double y, double z, double w)
        {
            X = x;
            Y = y;
            Z = z;
            W = w;
        }

        /// <summary>Returns the rotation by b, followed by a.</summary>
        public static Rotation<TAxes> operator *(in Rotation<TAxes> a, in Rotation<TAxes> b) =>
            new Rotation<TAxes>(
                a.W * b.X + a.X * b.W + a.Y * b.Z - a.Z * b.Y,
                a.W * b.Y - a.X * b.Z + a.Y * b.W + a.Z * b.X,
                a.W * b.Z + a.X * b.Y - a.Y * b.X + a.Z * b.W,
                a.W * b.W - a.X * b.X - a.Y * b.Y - a.Z * b.Z);

        /// <summary>Returns the same rotation as a unit quaternion.</summary>
        /// <exception cref="InvalidOperationException">The quaternion is zero or not finite.</exception>
        public Rotation<TAxes> Normalized()
        {
            double norm = Math.Sqrt(X * X + Y * Y + Z * Z + W * W);
            if (!(norm > 0) || double.IsInfinity(norm)) throw new InvalidOperationException($"Expected a rotation, found the quaternion {this}.");
            return new Rotation<TAxes>(X / norm, Y / norm, Z / norm, W / norm);
        }

        /// <summary>Returns components and axes as text.</summary>
        public override string ToString() => $"({X}, {Y}, {Z}, {W}) {typeof(TAxes).Name}";
    }

    /// <summary>The pose of an object in the world. Both the object and the world have the axes of the type.</summary>
    public readonly struct Pose<TAxes> where TAxes : struct
    {
        /// <summary>The position in the world, in metres.</summary>
        public readonly Vector3<TAxes> Position;

        /// <summary>The rotation from the object to the world.</summary>
        public readonly Rotation<TAxes> Rotation;

        /// <summary>Creates a pose from metres and a rotation from the object to the world.</summary>
        public Pose(in Vector3<TAxes> position, in Rotation<TAxes> rotation)
        {
            Position = position;
            Rotation = rotation;
        }
    }
}
