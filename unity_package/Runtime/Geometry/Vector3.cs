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
}
