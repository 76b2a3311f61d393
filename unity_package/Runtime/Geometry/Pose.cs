namespace Ml2Sensors.Geometry
{
    /// <summary>Where a thing is in the world, in metres; the axes of its type are those of the thing and of the world.</summary>
    public readonly struct Pose<TAxes> where TAxes : struct
    {
        /// <summary>Metres from the world's origin.</summary>
        public readonly Vector3<TAxes> Position;

        /// <summary>From the thing's axes to the world's.</summary>
        public readonly Rotation<TAxes> Rotation;

        /// <summary>Metres, and a rotation from the thing to the world.</summary>
        public Pose(in Vector3<TAxes> position, in Rotation<TAxes> rotation)
        {
            Position = position;
            Rotation = rotation;
        }
    }
}
