namespace Ml2Sensors.Geometry
{
    /// <summary>Where a thing is in the world, in metres; the axes of its type are those of the thing and of the world.</summary>
    public readonly struct Pose<TAxes> where TAxes : struct
    {
        public readonly Vector3<TAxes> Position;
        public readonly Rotation<TAxes> Rotation;

        public Pose(in Vector3<TAxes> position, in Rotation<TAxes> rotation)
        {
            Position = position;
            Rotation = rotation;
        }
    }
}
