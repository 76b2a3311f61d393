using System.Runtime.InteropServices;
using Ml2Sensors.Geometry;

namespace Ml2Sensors
{
    /// <summary>The axes of a sensor as Android defines them. Their orientation in the headset is not known.</summary>
    public struct SensorAxes
    {
    }

    /// <summary>A sample of an accelerometer (m/s^2) or a gyroscope (rad/s).</summary>
    [StructLayout(LayoutKind.Sequential)]
    public readonly struct ImuSample
    {
        /// <summary>The capture time, CLOCK_BOOTTIME.</summary>
        public readonly long CaptureNanos;

        /// <summary>The value in the axes of the sensor.</summary>
        public readonly Vector3<SensorAxes> Value;

        internal ImuSample(long captureNanos, in Vector3<SensorAxes> value)
        {
            CaptureNanos = captureNanos;
            Value = value;
        }
    }
}
