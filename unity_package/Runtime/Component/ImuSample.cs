using System.Runtime.InteropServices;
using Ml2Sensors.Geometry;

namespace Ml2Sensors
{
    /// <summary>Axes of a sensor as Android defines them for it; how they lie in the headset is not known.</summary>
    public struct SensorAxes
    {
    }

    /// <summary>One reading of an accelerometer (m/s^2) or a gyroscope (rad/s).</summary>
    [StructLayout(LayoutKind.Sequential)]
    public readonly struct ImuSample
    {
        /// <summary>CLOCK_BOOTTIME.</summary>
        public readonly long CaptureNanos;

        /// <summary>In the axes of the sensor.</summary>
        public readonly Vector3<SensorAxes> Value;

        internal ImuSample(long captureNanos, in Vector3<SensorAxes> value)
        {
            CaptureNanos = captureNanos;
            Value = value;
        }
    }
}
