using System;
using System.Runtime.InteropServices;
using Ml2Sensors.Geometry;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;

namespace Ml2Sensors.Interop
{
    /// <summary>
    /// Leases the latest frame of a stream, in the native library's memory. Acquire and release allocate nothing, so a reader
    /// reuses one FrameLease. Each frame is released exactly once: by Release, the next TryAcquire, Dispose or the finaliser.
    /// Capture continues in other slots meanwhile. Not thread-safe.
    /// </summary>
    public sealed unsafe class FrameLease : SafeHandle
    {
        private NativeFrame _frame = new NativeFrame { CaptureNanos = long.MinValue };

        /// <exception cref="DllNotFoundException">The native library is missing.</exception>
        /// <exception cref="NotSupportedException">The native library and this package have different versions.</exception>
        public FrameLease(StreamId stream) : base(IntPtr.Zero, true)
        {
            NativeMethods.CheckVersion();
            Stream = stream;
        }

        /// <summary>The stream whose frames are leased.</summary>
        public StreamId Stream { get; }

        /// <summary>True while no frame is held.</summary>
        public override bool IsInvalid => handle == IntPtr.Zero;

        /// <summary>The capture time (CLOCK_BOOTTIME) of the frame held, or of the last one.</summary>
        public long CaptureNanos => _frame.CaptureNanos;

        /// <summary>The device's frame number. Gaps are frames that were not read.</summary>
        public long FrameNumber => _frame.FrameNumber;

        /// <summary>Pixels per row.</summary>
        public int Width => (int)_frame.Width;

        /// <summary>Rows.</summary>
        public int Height => (int)_frame.Height;

        /// <summary>Bytes from one row to the next; 0 for JPEG.</summary>
        public int RowBytes => (int)_frame.Image.StrideBytes;

        /// <summary>The pose of the camera at the capture; null if the device did not report it.</summary>
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

        /// <summary>The head pose at the capture; null if the head is not tracked, or no stream of head poses runs.</summary>
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

        /// <summary>The camera intrinsics; null if the device did not report them.</summary>
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

        /// <summary>The bytes of the image, rows from the top. Not a copy: do not read it after the release.</summary>
        /// <exception cref="InvalidOperationException">No frame is held.</exception>
        public NativeArray<byte> Pixels
        {
            get
            {
                if (IsInvalid) throw new InvalidOperationException($"No frame of {Stream} is held. Call TryAcquire first.");
                byte* data = _frame.Data + _frame.Image.OffsetBytes;
                var array = NativeArrayUnsafeUtility.ConvertExistingDataToNativeArray<byte>(
                    data, (int)_frame.Image.SizeBytes, Allocator.None);
#if ENABLE_UNITY_COLLECTIONS_CHECKS
                NativeArrayUnsafeUtility.SetAtomicSafetyHandle(ref array, AtomicSafetyHandle.GetTempUnsafePtrSliceHandle());
#endif
                return array;
            }
        }

        /// <summary>Releases the frame held, and acquires the latest one if it is newer than the last one acquired.</summary>
        /// <returns>True if there is a newer frame.</returns>
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

        /// <summary>Releases the frame held. Has no effect if none is held.</summary>
        public void Release()
        {
            if (IsInvalid) return;
            if (!ReleaseHandle()) throw new InvalidOperationException($"A frame of {Stream} was released twice.");
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
