using Ml2Sensors.Messages;
using UnityEngine;

namespace Ml2Sensors.Samples
{
    /// <summary>Publishes the height of the camera ten times a second, on PREFIX/custom/head_height.</summary>
    public sealed class HeadHeight : MonoBehaviour
    {
        private const float PeriodSeconds = 0.1f;

        [SerializeField] private Ml2SensorStreamer _streamer;
        [SerializeField] private Transform _head;

        private readonly Float64Msg _message = new Float64Msg();
        private Ml2Publisher<Float64Msg> _publisher;
        private float _nextSeconds;

        private void Start()
        {
            if (_streamer.Unavailable != null) enabled = false;
            else _publisher = new Ml2Publisher<Float64Msg>(_streamer, "head_height");
        }

        private void Update()
        {
            if (Time.time < _nextSeconds) return;
            _nextSeconds = Time.time + PeriodSeconds;
            _message.data = _head.position.y;
            _publisher.Publish(_message, Ml2Publisher<Float64Msg>.NowNanos);
        }
    }
}
