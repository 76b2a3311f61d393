using System;
using System.Runtime.InteropServices;

namespace Ml2Sensors.Interop
{
    /// <summary>Readers' part of native/sdk/ml2s.h. Any thread; nothing blocks.</summary>
    internal static class NativeMethods
    {
        internal const string Library = "ml2sensors";

        /// <summary>Of the header these declarations were written to.</summary>
        internal const uint AbiVersion = 3;

        [DllImport(Library, EntryPoint = "ml2s_abi_version")]
        internal static extern uint GetAbiVersion();

        [DllImport(Library, EntryPoint = "ml2s_now")]
        internal static extern long Now();

        [DllImport(Library, EntryPoint = "ml2s_acquire_latest")]
        internal static extern NativeResult AcquireLatest(StreamId stream, long afterNanos, ref NativeFrame frame);

        [DllImport(Library, EntryPoint = "ml2s_release")]
        internal static extern NativeResult Release(StreamId stream, uint slot);

        [DllImport(Library, EntryPoint = "ml2s_use_openxr")]
        internal static extern NativeResult UseOpenXR(ref NativeOpenXR openXR, ref NativeError error);

        /// <param name="none">IntPtr.Zero: the session is about to end.</param>
        [DllImport(Library, EntryPoint = "ml2s_use_openxr")]
        internal static extern NativeResult UseOpenXR(IntPtr none, ref NativeError error);
    }

    /// <summary>ml2s_openxr.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeOpenXR
    {
        internal uint StructSize;
        private readonly uint _reserved;
        private readonly IntPtr _loaderPath;
        private readonly IntPtr _javaVm;
        private readonly IntPtr _activity;
        internal ulong Instance;
        internal ulong Session;
        internal IntPtr GetInstanceProcAddr;
    }

    /// <summary>ml2s_error.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeError
    {
        internal uint StructSize;
        internal int VendorCode;
        private fixed byte _message[248];

        internal static NativeError Sized() => new NativeError { StructSize = (uint)sizeof(NativeError) };

        internal string Message
        {
            get
            {
                fixed (byte* text = _message) return Marshal.PtrToStringAnsi((IntPtr)text);
            }
        }
    }
}
