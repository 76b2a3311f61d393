namespace Ml2Sensors.Geometry
{
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
