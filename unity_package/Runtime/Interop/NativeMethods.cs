using System;
using System.Runtime.InteropServices;

namespace Ml2Sensors.Interop
{
    /// <summary>The part of native/sdk/ml2s.h for frames and messages. Any thread; nothing blocks.</summary>
    internal static class NativeMethods
    {
        internal const string Library = "ml2sensors";

        /// <summary>The version of the header that these declarations were written to.</summary>
        internal const uint AbiVersion = 5;

        [DllImport(Library, EntryPoint = "ml2s_abi_version")]
        internal static extern uint GetAbiVersion();

        /// <exception cref="NotSupportedException">The native library and this package have different versions.</exception>
        internal static void CheckVersion()
        {
            uint version = GetAbiVersion();
            if (version != AbiVersion)
                throw new NotSupportedException($"Expected libml2sensors with interface {AbiVersion}, found {version}. Use the library of this package.");
        }

        [DllImport(Library, EntryPoint = "ml2s_now")]
        internal static extern long Now();

        [DllImport(Library, EntryPoint = "ml2s_acquire_latest")]
        internal static extern NativeResult AcquireLatest(StreamId stream, long afterNanos, ref NativeFrame frame);

        [DllImport(Library, EntryPoint = "ml2s_release")]
        internal static extern NativeResult Release(StreamId stream, uint slot);

        [DllImport(Library, EntryPoint = "ml2s_inbox_take")]
        internal static extern NativeResult TakeMessage(uint inbox, ulong sizeBytes, out uint slot, out NativeMemory memory);

        [DllImport(Library, EntryPoint = "ml2s_inbox_add")]
        internal static extern NativeResult AddMessage(uint inbox, ref NativeMessage message);

        [DllImport(Library, EntryPoint = "ml2s_inbox_acquire")]
        internal static extern NativeResult AcquireMessage(uint inbox, ref NativeMessage message);

        [DllImport(Library, EntryPoint = "ml2s_inbox_release")]
        internal static extern NativeResult ReleaseMessage(uint inbox, uint slot);

        [DllImport(Library, EntryPoint = "ml2s_inbox_skip")]
        internal static extern NativeResult SkipMessages(uint inbox);

        [DllImport(Library, EntryPoint = "ml2s_use_openxr")]
        internal static extern NativeResult UseOpenXR(ref NativeOpenXR openXR, ref NativeError error);

        /// <param name="none">IntPtr.Zero: the session is about to end.</param>
        [DllImport(Library, EntryPoint = "ml2s_use_openxr")]
        internal static extern NativeResult UseOpenXR(IntPtr none, ref NativeError error);
    }

    /// <summary>ml2s_memory.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeMemory
    {
        internal IntPtr Data;
        internal ulong SizeBytes;
    }

    /// <summary>ml2s_message.</summary>
    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeMessage
    {
        internal uint StructSize;
        internal uint Slot;
        internal IntPtr Data;
        internal ulong SizeBytes;
        internal long PublishedNanos;
        internal uint Number;
        private readonly uint _reserved;
        internal ulong LeftOut;

        internal static unsafe NativeMessage Sized() => new NativeMessage { StructSize = (uint)sizeof(NativeMessage) };
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
