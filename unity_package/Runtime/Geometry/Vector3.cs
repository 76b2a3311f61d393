namespace Ml2Sensors.Geometry
{
    /// <summary>A vector whose axes are in its type, so that those of two systems cannot be mixed up.</summary>
    public readonly struct Vector3<TAxes> where TAxes : struct
    {
        public readonly double X;
        public readonly double Y;
        public readonly double Z;

        public Vector3(double x, double y, double z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        public static Vector3<TAxes> operator +(in Vector3<TAxes> a, in Vector3<TAxes> b) =>
            new Vector3<TAxes>(a.X + b.X, a.Y + b.Y, a.Z + b.Z);

        public static Vector3<TAxes> operator -(in Vector3<TAxes> a, in Vector3<TAxes> b) =>
            new Vector3<TAxes>(a.X - b.X, a.Y - b.Y, a.Z - b.Z);

        public static Vector3<TAxes> operator *(double scale, in Vector3<TAxes> vector) =>
            new Vector3<TAxes>(scale * vector.X, scale * vector.Y, scale * vector.Z);

        public override string ToString() => $"({X}, {Y}, {Z}) {typeof(TAxes).Name}";
    }
}
