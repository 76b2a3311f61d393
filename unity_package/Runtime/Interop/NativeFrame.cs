using System;
using System.Runtime.InteropServices;

namespace Ml2Sensors.Interop
{
    internal enum NativeResult
    {
        Ok = 0,
        Timeout = 1,
        InvalidArgument = 2,
        Closed = 4,
        AllSlotsLeased = 7,
        Busy = 8,
    }

    [Flags]
    internal enum FrameFields : uint
    {
        Pose = 1,
        Intrinsics = 2,
        HeadPose = 64,
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativePlane
    {
        internal uint OffsetBytes;
        internal uint SizeBytes;
        internal uint StrideBytes;
        private readonly uint _reserved;
    }

    /// <summary>ml2s_frame of native/sdk/ml2s.h.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeFrame
    {
        internal uint StructSize;
        internal StreamId Stream;
        internal uint Slot;
        internal FrameFields Has;
        internal long FrameNumber;
        internal long CaptureNanos;
        internal long DeviceNanos;
        internal byte* Data;
        internal NativePlane Image;
        internal NativePlane Confidence;
        internal NativePlane Flags;
        internal uint Width;
        internal uint Height;
        internal fixed float Rotation[4];
        internal fixed float Position[3];
        internal uint Lens;
        internal fixed double FocalLength[2];
        internal fixed double PrincipalPoint[2];
        internal fixed double Distortion[6];
        internal long ExposureNanos;
        internal uint AnalogGain;
        internal uint DigitalGain;
        internal uint Illumination;
        internal uint Skipped;
        internal fixed float HeadRotation[4];
        internal fixed float HeadPosition[3];
        private readonly uint _reserved;

        internal static NativeFrame Sized() => new NativeFrame { StructSize = (uint)sizeof(NativeFrame) };
    }
}
