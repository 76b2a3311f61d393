using System;
using System.Diagnostics;
using Ml2Sensors.Geometry;
using Ml2Sensors.Interop;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;

namespace Ml2Sensors
{
    /// <summary>
    /// Shows the latest frame of a camera or the depth sensor, upright, with where the camera was and what its lens is.
    /// Raw images go from the library's memory to the texture in one copy and without garbage: R8 for mono8, RFloat for
    /// 32FC1 (metres, NaN where there is none). Unity decodes a JPEG on the main thread; DecodeMilliseconds tells what
    /// that costs.
    /// </summary>
    [AddComponentMenu("ML2 Sensors/ML2 Camera Texture")]
    public sealed class Ml2CameraTexture : MonoBehaviour
    {
        [SerializeField] private Ml2SensorStreamer _streamer;
        [SerializeField] private StreamId _stream = StreamId.WorldLeft;

        [Tooltip("Gets the texture as its main texture; may be empty.")]
        [SerializeField] private Renderer _target;

        private FrameLease _lease;
        private byte[] _jpeg = new byte[0];
        private StreamId _viewed;

        /// <summary>Raised after Texture was made anew: with the first frame, and when the size changes.</summary>
        public event Action<Texture2D> TextureCreated;

        /// <summary>Null until the first frame. This component's; destroyed with it.</summary>
        public Texture2D Texture { get; private set; }

        /// <summary>CLOCK_BOOTTIME of the frame shown.</summary>
        public long CaptureNanos => _lease == null ? 0 : _lease.CaptureNanos;

        /// <summary>
        /// The camera at the capture of the frame shown: x right, y up, z into the picture, in the world of the headset's
        /// tracking, metres. Null when the device did not say.
        /// </summary>
        public Pose? CameraPose { get; private set; }

        /// <summary>
        /// The head at the capture of the frame shown, in the axes and the world of CameraPose; interpolated between the
        /// poses of a stream that runs (head_pose or tf). Null without one, and while the head is not tracked.
        /// </summary>
        public Pose? HeadPose { get; private set; }

        /// <summary>The lens for the frame shown; null when the device did not say.</summary>
        public CameraIntrinsics? Intrinsics => _lease == null ? null : _lease.Intrinsics;

        /// <summary>The time in ms that the main thread took to decode the JPEG shown; 0 for raw images.</summary>
        public double DecodeMilliseconds { get; private set; }

        /// <summary>The streamer and the stream shown; takes effect when this component is next enabled.</summary>
        public void Show(Ml2SensorStreamer streamer, StreamId stream)
        {
            _streamer = streamer;
            _stream = stream;
        }

        private void OnEnable()
        {
            if (_streamer == null || _streamer.Unavailable != null) return;
            _viewed = _stream;
            CameraPose = null;
            HeadPose = null;
            DecodeMilliseconds = 0;
            _streamer.AddView(_viewed);
            _lease = new FrameLease(_viewed);
        }

        private void Update()
        {
            if (_lease == null || !_lease.TryAcquire()) return;
            try
            {
                CameraPose = _lease.Pose?.ToUnity().ToPose();
                HeadPose = _lease.HeadPose?.ToUnity().ToPose();
                if (_lease.RowBytes == 0) ShowJpeg(_lease.Pixels);
                else ShowRows(_lease.Pixels);
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

        private void OnDestroy()
        {
            if (Texture != null) Destroy(Texture);
        }

        /// <summary>Rows of a frame begin at the top, those of a texture at the bottom.</summary>
        private unsafe void ShowRows(NativeArray<byte> pixels)
        {
            int width = _lease.Width, height = _lease.Height, stride = _lease.RowBytes;
            int pixelBytes = pixels.Length == 0 ? 0 : stride / width >= 4 ? 4 : 1;
            int rowBytes = width * pixelBytes;
            if (pixelBytes == 0 || pixels.Length < (height - 1) * stride + rowBytes)
                throw new NotSupportedException(
                    $"{_viewed}: expected {height} rows of {stride} bytes, found {pixels.Length} bytes.");
            Fit(width, height, pixelBytes == 1 ? TextureFormat.R8 : TextureFormat.RFloat);
            var source = (byte*)pixels.GetUnsafeReadOnlyPtr();
            var target = (byte*)Texture.GetRawTextureData<byte>().GetUnsafePtr();
            for (int row = 0; row < height; row++)
                UnsafeUtility.MemCpy(target + (long)(height - 1 - row) * rowBytes, source + (long)row * stride, rowBytes);
            Texture.Apply(false);
        }

        private void ShowJpeg(NativeArray<byte> jpeg)
        {
            // A decoder ignores bytes behind the end of a JPEG, so a larger array serves a smaller picture.
            if (_jpeg.Length < jpeg.Length) _jpeg = new byte[jpeg.Length * 2];
            NativeArray<byte>.Copy(jpeg, 0, _jpeg, 0, jpeg.Length);
            Fit(_lease.Width, _lease.Height, TextureFormat.RGB24);
            long begin = Stopwatch.GetTimestamp();
            if (!Texture.LoadImage(_jpeg)) throw new FormatException($"{_viewed}: Unity cannot read this JPEG.");
            DecodeMilliseconds = (Stopwatch.GetTimestamp() - begin) * 1000.0 / Stopwatch.Frequency;
        }

        private void Fit(int width, int height, TextureFormat format)
        {
            if (Texture != null && Texture.width == width && Texture.height == height && Texture.format == format) return;
            if (Texture != null) Destroy(Texture);
            Texture = new Texture2D(width, height, format, false, true) { name = _viewed.ToString() };
            if (_target != null) _target.material.mainTexture = Texture;
            TextureCreated?.Invoke(Texture);
        }
    }
}
