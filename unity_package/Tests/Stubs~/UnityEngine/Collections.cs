using System;
using System.Runtime.InteropServices;

namespace Unity.Collections
{
    public enum Allocator
    {
        Invalid,
        None,
    }

    public unsafe struct NativeArray<T> where T : struct
    {
        internal byte* Data;

        public int Length { get; internal set; }

        public T this[int index]
        {
            get
            {
                if ((uint)index >= (uint)Length) throw new IndexOutOfRangeException();
                return Marshal.PtrToStructure<T>((IntPtr)(Data + index * Marshal.SizeOf<T>()));
            }
        }

        public static void Copy(NativeArray<T> source, int sourceIndex, T[] target, int targetIndex, int length)
        {
            for (int i = 0; i < length; i++) target[targetIndex + i] = source[sourceIndex + i];
        }

        public NativeArray<U> Reinterpret<U>(int expectedTypeSize) where U : struct
        {
            if (expectedTypeSize != Marshal.SizeOf<T>()) throw new InvalidOperationException();
            int bytes = Length * expectedTypeSize;
            if (bytes % Marshal.SizeOf<U>() != 0) throw new InvalidOperationException();
            return new NativeArray<U> { Data = Data, Length = bytes / Marshal.SizeOf<U>() };
        }
    }
}

namespace Unity.Collections.LowLevel.Unsafe
{
    public struct AtomicSafetyHandle
    {
        public static AtomicSafetyHandle GetTempUnsafePtrSliceHandle() => default(AtomicSafetyHandle);
    }

    public static unsafe class UnsafeUtility
    {
        public static void MemCpy(void* destination, void* source, long size) =>
            Buffer.MemoryCopy(source, destination, size, size);
    }

    public static unsafe class NativeArrayUnsafeUtility
    {
        public static NativeArray<T> ConvertExistingDataToNativeArray<T>(void* data, int length, Allocator allocator)
            where T : struct => new NativeArray<T> { Data = (byte*)data, Length = length };

        public static void SetAtomicSafetyHandle<T>(ref NativeArray<T> array, AtomicSafetyHandle handle) where T : struct
        {
        }

        public static void* GetUnsafePtr<T>(this NativeArray<T> array) where T : struct => array.Data;

        public static void* GetUnsafeReadOnlyPtr<T>(this NativeArray<T> array) where T : struct => array.Data;
    }
}
