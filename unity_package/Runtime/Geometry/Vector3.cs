namespace Ml2Sensors.Geometry
{
    /// <summary>A vector whose axes are in its type, so that those of two systems cannot be mixed up.</summary>
    public readonly struct Vector3<TAxes> where TAxes : struct
    {
        /// <summary>Along the first axis.</summary>
        public readonly double X;

        /// <summary>Along the second axis.</summary>
        public readonly double Y;

        /// <summary>Along the third axis.</summary>
        public readonly double Z;

        /// <summary>In the axes of its type.</summary>
        public Vector3(double x, double y, double z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        /// <summary>Sum.</summary>
        public static Vector3<TAxes> operator +(in Vector3<TAxes> a, in Vector3<TAxes> b) =>
            new Vector3<TAxes>(a.X + b.X, a.Y + b.Y, a.Z + b.Z);

        /// <summary>Difference.</summary>
        public static Vector3<TAxes> operator -(in Vector3<TAxes> a, in Vector3<TAxes> b) =>
            new Vector3<TAxes>(a.X - b.X, a.Y - b.Y, a.Z - b.Z);

        /// <summary>The same direction, scaled.</summary>
        public static Vector3<TAxes> operator *(double scale, in Vector3<TAxes> vector) =>
            new Vector3<TAxes>(scale * vector.X, scale * vector.Y, scale * vector.Z);

        /// <summary>Components and axes.</summary>
        public override string ToString() => $"({X}, {Y}, {Z}) {typeof(TAxes).Name}";
    }
}
