using System;
using Ml2Sensors.Interop;
using Unity.Collections;
using UnityEngine;

namespace Ml2Sensors
{
    /// <summary>
    /// Shows the latest frame of a camera or the depth sensor. Raw images go from the library's memory to the texture in
    /// one copy and without garbage: R8 for mono8, RFloat for 32FC1 (metres, NaN where there is none). A JPEG is decoded
    /// on the main thread, which takes milliseconds. Rows begin at the top, so the image is upside down in Unity's
    /// texture coordinates: use a scale of (1, -1).
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
            _streamer.AddView(_viewed);
            _lease = new FrameLease(_viewed);
        }

        private void Update()
        {
            if (_lease == null || !_lease.TryAcquire()) return;
            try
            {
                if (_lease.RowBytes == 0) ShowJpeg(_lease.Pixels);
                else ShowPixels(_lease.Pixels);
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

        private void ShowPixels(NativeArray<byte> pixels)
        {
            int pixelBytes = _lease.RowBytes / _lease.Width;
            if (pixelBytes * _lease.Width * _lease.Height != pixels.Length || (pixelBytes != 1 && pixelBytes != 4))
                throw new NotSupportedException(
                    $"{_viewed}: expected rows of 1 or 4 bytes per pixel without padding, found {_lease.RowBytes} bytes " +
                    $"for {_lease.Width} pixels.");
            Fit(_lease.Width, _lease.Height, pixelBytes == 1 ? TextureFormat.R8 : TextureFormat.RFloat);
            Texture.LoadRawTextureData(pixels);
            Texture.Apply(false);
        }

        private void ShowJpeg(NativeArray<byte> jpeg)
        {
            // What stands behind the end of a JPEG is ignored, so a larger array serves a smaller picture.
            if (_jpeg.Length < jpeg.Length) _jpeg = new byte[jpeg.Length * 2];
            NativeArray<byte>.Copy(jpeg, 0, _jpeg, 0, jpeg.Length);
            Fit(_lease.Width, _lease.Height, TextureFormat.RGB24);
            if (!Texture.LoadImage(_jpeg)) throw new FormatException($"{_viewed}: Unity cannot read this JPEG.");
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
