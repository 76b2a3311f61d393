using System;
using UnityEngine;

namespace Ml2Sensors.Tests
{
    /// <summary>A scene with a streamer and a camera texture, enabled while this lives.</summary>
    internal sealed class CameraTextureScene : IDisposable
    {
        private readonly Ml2SensorStreamer _streamer;

        public CameraTextureScene(StreamId stream)
        {
            var scene = new GameObject("scene");
            _streamer = scene.AddComponent<Ml2SensorStreamer>();
            _streamer.OpenBridge = changed => Bridge = new ScriptedBridge(changed);
            Component = scene.AddComponent<Ml2CameraTexture>();
            Component.Show(_streamer, stream);
            Component.enabled = true;
        }

        public Ml2CameraTexture Component { get; }

        public ScriptedBridge Bridge { get; private set; }

        public Texture2D Texture => Component.Texture;

        public void Update() => Component.Send("Update");

        public void Dispose()
        {
            Component.enabled = false;
            Component.Send("OnDestroy");
            _streamer.Send("OnDestroy");
        }
    }
}
