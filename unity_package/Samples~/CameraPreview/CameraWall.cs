using UnityEngine;

namespace Ml2Sensors.Samples
{
    /// <summary>A row of quads, each with the latest frame of one camera.</summary>
    public sealed class CameraWall : MonoBehaviour
    {
        private static readonly StreamId[] Cameras =
        {
            StreamId.WorldLeft, StreamId.WorldCenter, StreamId.WorldRight, StreamId.Color, StreamId.Depth,
        };

        [SerializeField] private Ml2SensorStreamer _streamer;

        [Tooltip("With a material whose shader shows a texture unlit.")]
        [SerializeField] private Renderer _quad;

        private void Start()
        {
            for (int i = 0; i < Cameras.Length; i++)
            {
                Renderer quad = Instantiate(_quad, transform);
                quad.transform.localPosition = new Vector3(1.1f * i, 0, 0);
                quad.gameObject.SetActive(false);
                var camera = quad.gameObject.AddComponent<Ml2CameraTexture>();
                camera.Show(_streamer, Cameras[i]);
                camera.TextureCreated += texture => Hang(quad, texture);
                quad.gameObject.SetActive(true);
            }
        }

        /// <summary>Rows of a frame begin at the top, those of a texture at the bottom.</summary>
        private static void Hang(Renderer quad, Texture texture)
        {
            quad.material.mainTexture = texture;
            quad.material.mainTextureScale = new Vector2(1, -1);
        }
    }
}
