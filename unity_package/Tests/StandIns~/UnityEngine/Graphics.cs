using System;
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

        /// <summary>What was loaded, until Apply only on this side.</summary>
        public byte[] Raw { get; }

        public int Applied { get; private set; }

        public byte[] Jpeg { get; internal set; }

        public unsafe void LoadRawTextureData<T>(NativeArray<T> data) where T : struct
        {
            if (data.Length != Raw.Length) throw new ArgumentException($"Expected {Raw.Length} bytes, found {data.Length}.");
            Marshal.Copy((IntPtr)data.GetUnsafeReadOnlyPtr(), Raw, 0, Raw.Length);
        }

        public void Apply(bool updateMipmaps) => Applied++;
    }

    public static class ImageConversion
    {
        public static bool LoadImage(this Texture2D texture, byte[] data)
        {
            texture.Jpeg = data;
            return data[0] == 0xff && data[1] == 0xd8;
        }
    }

    public class Material : Object
    {
        public Texture mainTexture { get; set; }
        public Vector2 mainTextureScale { get; set; }
    }

    public class Renderer : Component
    {
        public Material material { get; } = new Material();
    }
}
