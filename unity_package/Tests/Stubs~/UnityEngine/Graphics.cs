using System;
using System.Diagnostics;
using System.Runtime.InteropServices;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;

namespace UnityEngine
{
    public struct Vector2
    {
        public float x, y;

        public Vector2(float x, float y)
        {
            this.x = x;
            this.y = y;
        }
    }

    public struct Vector3
    {
        public float x, y, z;

        public Vector3(float x, float y, float z)
        {
            this.x = x;
            this.y = y;
            this.z = z;
        }
    }

    public struct Quaternion
    {
        public float x, y, z, w;

        public Quaternion(float x, float y, float z, float w)
        {
            this.x = x;
            this.y = y;
            this.z = z;
            this.w = w;
        }
    }

    public struct Pose
    {
        public Vector3 position;
        public Quaternion rotation;

        public Pose(Vector3 position, Quaternion rotation)
        {
            this.position = position;
            this.rotation = rotation;
        }
    }

    public struct Rect
    {
        public Rect(float x, float y, float width, float height)
        {
        }
    }

    public enum TextureFormat
    {
        RGB24 = 3,
        RFloat = 18,
        R8 = 63,
    }

    public class Texture : Object
    {
    }

    public class Texture2D : Texture
    {
        public Texture2D(int width, int height, TextureFormat format, bool mipChain, bool linear)
        {
            this.width = width;
            this.height = height;
            this.format = format;
            Raw = new byte[width * height * (format == TextureFormat.R8 ? 1 : format == TextureFormat.RGB24 ? 3 : 4)];
        }

        public int width { get; }
        public int height { get; }
        public TextureFormat format { get; }

        /// <summary>The bytes written, until Apply only on this side; rows begin at the bottom.</summary>
        public byte[] Raw { get; }

        private GCHandle _pinned;

        public int Applied { get; private set; }

        public byte[] Jpeg { get; internal set; }

        public unsafe NativeArray<T> GetRawTextureData<T>() where T : struct
        {
            if (!_pinned.IsAllocated) _pinned = GCHandle.Alloc(Raw, GCHandleType.Pinned);
            return NativeArrayUnsafeUtility.ConvertExistingDataToNativeArray<T>(
                (void*)_pinned.AddrOfPinnedObject(), Raw.Length / Marshal.SizeOf<T>(), Allocator.None);
        }

        public void Apply(bool updateMipmaps) => Applied++;
    }

    public static class ImageConversion
    {
        public static bool LoadImage(this Texture2D texture, byte[] data)
        {
            texture.Jpeg = data;
            // A decoder takes time that a clock can see.
            for (long begin = Stopwatch.GetTimestamp(); Stopwatch.GetTimestamp() == begin;)
            {
            }
            return data[0] == 0xff && data[1] == 0xd8;
        }
    }

    public class Material : Object
    {
        public Texture mainTexture { get; set; }

        public void SetFloat(string name, float value)
        {
        }
    }

    public class Renderer : Component
    {
        public Material material { get; } = new Material();
    }
}
