using UnityEngine;

namespace Ml2Sensors.Samples
{
    /// <summary>Shows the latest frame of each camera on a row of quads.</summary>
    public sealed class CameraWall : MonoBehaviour
    {
        private const float DepthShownWhiteMetres = 5;

        private static readonly StreamId[] Cameras =
        {
            StreamId.WorldLeft, StreamId.WorldCenter, StreamId.WorldRight, StreamId.Color, StreamId.Depth,
        };

        [SerializeField] private Ml2SensorStreamer _streamer;

        [Tooltip("A quad with the material CameraPreview.")]
        [SerializeField] private Renderer _quad;

        private void Start()
        {
            for (int i = 0; i < Cameras.Length; i++)
            {
                Renderer quad = Instantiate(_quad, transform);
                quad.transform.localPosition = new Vector3(1.1f * (i - Cameras.Length / 2), 0, 0);
                quad.gameObject.SetActive(false);
                var camera = quad.gameObject.AddComponent<Ml2CameraTexture>();
                camera.Show(_streamer, Cameras[i]);
                camera.TextureCreated += texture => ShowTexture(quad.material, texture);
                quad.gameObject.SetActive(true);
            }
            _quad.gameObject.SetActive(false);
        }

        private static void ShowTexture(Material material, Texture2D texture)
        {
            material.mainTexture = texture;
            material.SetFloat("_Grey", texture.format == TextureFormat.RGB24 ? 0 : 1);
            material.SetFloat("_White", texture.format == TextureFormat.RFloat ? DepthShownWhiteMetres : 1);
        }
    }
}
