using System;
using System.Runtime.InteropServices;
using Ml2Sensors.Geometry;
using Ml2Sensors.Interop;
using UnityEngine;

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

    /// <summary>
    /// Raises each sample of an accelerometer or gyroscope once and in order. Each Update raises the samples since the last
    /// one. A frame of such a stream holds its latest samples as ImuSamples, oldest first.
    /// </summary>
    [AddComponentMenu("ML2 Sensors/ML2 IMU Feed")]
    public sealed class Ml2ImuFeed : MonoBehaviour
    {
        [SerializeField] private Ml2SensorStreamer _streamer;
        [SerializeField] private StreamId _stream = StreamId.GyroLeft;

        private FrameLease _lease;
        private StreamId _viewed;
        private long _lastNanos;

        /// <summary>Raised for each sample, on the main thread.</summary>
        public event Action<ImuSample> Sampled;

        /// <summary>Sets the streamer and the stream. Takes effect when this component is next enabled.</summary>
        /// <exception cref="ArgumentException">The stream is not an accelerometer or gyroscope.</exception>
        public void Read(Ml2SensorStreamer streamer, StreamId stream)
        {
            Require(stream);
            _streamer = streamer;
            _stream = stream;
        }

        private void OnEnable()
        {
            if (_streamer == null || _streamer.Unavailable != null) return;
            Require(_stream);
            _viewed = _stream;
            _streamer.AddView(_viewed);
            _lease = new FrameLease(_viewed);
            _lastNanos = long.MinValue;
        }

        private void Update()
        {
            if (_lease == null || !_lease.TryAcquire()) return;
            try
            {
                var samples = _lease.Pixels.Reinterpret<ImuSample>(1);
                for (int i = 0; i < samples.Length; i++)
                {
                    ImuSample sample = samples[i];
                    if (sample.CaptureNanos <= _lastNanos) continue;
                    _lastNanos = sample.CaptureNanos;
                    Sampled?.Invoke(sample);
                }
            }
            finally
            {
                _lease.Release();
            }
        }

        private void OnDisable()
        {
            if (_lease == null) return;
            _lease.Dispose();
            _lease = null;
            _streamer.RemoveView(_viewed);
        }

        private static void Require(StreamId stream)
        {
            if (stream < StreamId.AccelLeft || stream > StreamId.GyroComputePack)
                throw new ArgumentException($"Expected an accelerometer or gyroscope, found {stream}.", nameof(stream));
        }
    }
}
