using System;
using System.Runtime.InteropServices;
using Ml2Sensors.Geometry;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;

namespace Ml2Sensors.Interop
{
    /// <summary>
    /// The latest frame of a stream, in the native library's memory, lent to one reader at a time. Acquiring and
    /// releasing allocate nothing, so one lease serves a reader for ever. A frame is given back exactly once: by Release,
    /// the next TryAcquire, Dispose or the finaliser. While it is held, capture goes on in other slots. One thread.
    /// </summary>
    public sealed unsafe class FrameLease : SafeHandle
    {
        private NativeFrame _frame = new NativeFrame { CaptureNanos = long.MinValue };

        /// <exception cref="DllNotFoundException">The native library is not here.</exception>
        /// <exception cref="NotSupportedException">It is of another version than this package.</exception>
        public FrameLease(StreamId stream) : base(IntPtr.Zero, true)
        {
            uint version = NativeMethods.GetAbiVersion();
            if (version != NativeMethods.AbiVersion)
                throw new NotSupportedException($"Expected libml2sensors of interface {NativeMethods.AbiVersion}, found {version}.");
            Stream = stream;
        }

        /// <summary>Whose frames it leases.</summary>
        public StreamId Stream { get; }

        /// <summary>True while no frame is held.</summary>
        public override bool IsInvalid => handle == IntPtr.Zero;

        /// <summary>CLOCK_BOOTTIME of the frame held, or of the last one.</summary>
        public long CaptureNanos => _frame.CaptureNanos;

        /// <summary>The device's own; gaps are frames that were not seen.</summary>
        public long FrameNumber => _frame.FrameNumber;

        /// <summary>Pixels per row.</summary>
        public int Width => (int)_frame.Width;

        /// <summary>Rows.</summary>
        public int Height => (int)_frame.Height;

        /// <summary>From one row to the next; 0 for JPEG.</summary>
        public int RowBytes => (int)_frame.Image.StrideBytes;

        /// <summary>Where the camera was at the capture; null when the device did not say.</summary>
        public Pose<MlRub>? Pose
        {
            get
            {
                if ((_frame.Has & FrameFields.Pose) == 0) return null;
                NativeFrame frame = _frame;
                return new Pose<MlRub>(
                    new Vector3<MlRub>(frame.Position[0], frame.Position[1], frame.Position[2]),
                    new Rotation<MlRub>(frame.Rotation[0], frame.Rotation[1], frame.Rotation[2], frame.Rotation[3]));
            }
        }

        /// <summary>Where the head was at the capture; null while it is not tracked, or no stream of its poses runs.</summary>
        public Pose<MlRub>? HeadPose
        {
            get
            {
                if ((_frame.Has & FrameFields.HeadPose) == 0) return null;
                NativeFrame frame = _frame;
                return new Pose<MlRub>(
                    new Vector3<MlRub>(frame.HeadPosition[0], frame.HeadPosition[1], frame.HeadPosition[2]),
                    new Rotation<MlRub>(
                        frame.HeadRotation[0], frame.HeadRotation[1], frame.HeadRotation[2], frame.HeadRotation[3]));
            }
        }

        /// <summary>The lens of the capture; null when the device did not say.</summary>
        public CameraIntrinsics? Intrinsics
        {
            get
            {
                if ((_frame.Has & FrameFields.Intrinsics) == 0) return null;
                NativeFrame frame = _frame;
                return new CameraIntrinsics(
                    Width, Height,
                    frame.FocalLength[0], frame.FocalLength[1],
                    frame.PrincipalPoint[0], frame.PrincipalPoint[1],
                    new LensDistortion(
                        (LensModel)frame.Lens, frame.Distortion[0], frame.Distortion[1], frame.Distortion[2],
                        frame.Distortion[3], frame.Distortion[4], frame.Distortion[5]));
            }
        }

        /// <summary>The image's bytes, rows from the top. Not a copy: reading it after the release is a fault.</summary>
        /// <exception cref="InvalidOperationException">No frame is held.</exception>
        public NativeArray<byte> Pixels
        {
            get
            {
                if (IsInvalid) throw new InvalidOperationException($"No frame of {Stream} is held.");
                byte* data = _frame.Data + _frame.Image.OffsetBytes;
                var array = NativeArrayUnsafeUtility.ConvertExistingDataToNativeArray<byte>(
                    data, (int)_frame.Image.SizeBytes, Allocator.None);
#if ENABLE_UNITY_COLLECTIONS_CHECKS
                NativeArrayUnsafeUtility.SetAtomicSafetyHandle(ref array, AtomicSafetyHandle.GetTempUnsafePtrSliceHandle());
#endif
                return array;
            }
        }

        /// <summary>Gives back what is held, and takes the latest frame if it was captured after the last one taken.</summary>
        /// <returns>Whether there was one.</returns>
        public bool TryAcquire()
        {
            if (IsClosed) throw new ObjectDisposedException(nameof(FrameLease));
            Release();
            NativeFrame frame = NativeFrame.Sized();
            NativeResult result = NativeMethods.AcquireLatest(Stream, _frame.CaptureNanos, ref frame);
            if (result == NativeResult.Timeout) return false;
            if (result != NativeResult.Ok) throw new InvalidOperationException($"ml2s_acquire_latest of {Stream}: {result}.");
            _frame = frame;
            SetHandle((IntPtr)(frame.Slot + 1L));
            return true;
        }

        /// <summary>Gives back what is held; without effect when nothing is.</summary>
        public void Release()
        {
            if (IsInvalid) return;
            if (!ReleaseHandle()) throw new InvalidOperationException($"A frame of {Stream} had been released before.");
        }

        /// <summary>Called once for each frame, by Release or the finalizer.</summary>
        protected override bool ReleaseHandle()
        {
            uint slot = (uint)((long)handle - 1);
            SetHandle(IntPtr.Zero);
            return NativeMethods.Release(Stream, slot) == NativeResult.Ok;
        }
    }
}
