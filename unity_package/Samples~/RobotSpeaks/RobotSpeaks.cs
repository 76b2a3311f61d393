using System;
using System.Text;
using Ml2Sensors.Geometry;
using Ml2Sensors.Messages;
using UnityEngine;

namespace Ml2Sensors.Samples
{
    /// <summary>
    /// Asks a robot how it is. Shows its answer, its texts and its joints, and a marker at its pose in magicleap_world. On
    /// the ROS PC, app.subscribe must list /joint_states, /robot_text and /robot_pose, and app.call /robot_status.
    /// </summary>
    public sealed class RobotSpeaks : MonoBehaviour
    {
        private const double DegreesPerRadian = 180 / Math.PI;
        private const float SecondsToAnswer = 30;

        [SerializeField] private Ml2SensorStreamer _streamer;
        [SerializeField] private TextMesh _text;
        [SerializeField] private Transform _marker;

        private Ml2Subscriber<JointStateMsg> _joints;
        private Ml2Subscriber<StringMsg> _words;
        private Ml2Subscriber<PoseStampedMsg> _pose;
        private Ml2ServiceClient<TriggerRequest, TriggerResponse> _status;
        private string _answer = "", _said = "", _angles = "";

        private void OnEnable()
        {
            // The text comes from others, and shall not be read as tags.
            _text.richText = false;
            _joints = new Ml2Subscriber<JointStateMsg>(_streamer, "/joint_states");
            _words = new Ml2Subscriber<StringMsg>(_streamer, "/robot_text", depth: 10);
            _pose = new Ml2Subscriber<PoseStampedMsg>(_streamer, "/robot_pose");
            _joints.Received += ShowJoints;
            _words.Received += ShowText;
            _pose.Received += Follow;
            _status = new Ml2ServiceClient<TriggerRequest, TriggerResponse>(_streamer, "/robot_status");
            Ask();
        }

        private void OnDisable()
        {
            _joints.Dispose();
            _words.Dispose();
            _pose.Dispose();
            Ml2ServiceClient<TriggerRequest, TriggerResponse> ended = _status;
            _status = null;
            ended.Dispose();
        }

        /// <summary>Calls the service; the call waits for the connection.</summary>
        private async void Ask()
        {
            Ml2ServiceClient<TriggerRequest, TriggerResponse> asked = _status;
            ServiceResult<TriggerResponse> result = await asked.CallAsync(new TriggerRequest(), SecondsToAnswer);
            if (asked != _status || _text == null) return; // Disabled, or the scene has ended
            _answer = (result.Failure == ServiceFailure.None ? result.Response.message : $"no answer: {result.Reason}") + "\n";
            Show();
        }

        private void ShowText(StringMsg message)
        {
            _said = message.data;
            Show();
        }

        private void ShowJoints(JointStateMsg message)
        {
            var lines = new StringBuilder();
            // A joint state may leave out its positions
            for (int i = 0; i < message.name.Length && i < message.position.Length; i++)
                lines.Append('\n').Append(message.name[i]).Append(' ').Append(Math.Round(message.position[i] * DegreesPerRadian)).Append('°');
            _angles = lines.ToString();
            Show();
        }

        private void Show() => _text.text = _answer + _said + _angles;

        private void Follow(PoseStampedMsg message)
        {
            PointMsg at = message.pose.position;
            QuaternionMsg to = message.pose.orientation;
            // A publisher that sets no rotation may send zeros
            if (to.x == 0 && to.y == 0 && to.z == 0 && to.w == 0) return;
            var pose = new Pose<Ros>(new Vector3<Ros>(at.x, at.y, at.z), new Rotation<Ros>(to.x, to.y, to.z, to.w)).ToUnity().ToPose();
            _marker.SetPositionAndRotation(pose.position, pose.rotation);
        }
    }
}
