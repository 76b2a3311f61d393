"""`ml2-receiver compat` publishes as the thesis's scripts did."""

import json
from collections.abc import Iterator

import pytest

import ros_messages
from configurations import only
from ml2_receiver.topics.plain_messages import encode_string
from ml2_tools.compatibility.thesis import configuration_text, metadata_text
from mock_device import MockDevice
from repeated import repeated
from ros_processes import Child

CONFIG = only(
    """
    general: {topic_name: /magic_leap2},
    world_center: {enabled: true},
    picture_center: {enabled: true, resolution_width: 1280, resolution_height: 720},
    other_sensors: {enabled: true},
    """
)
METADATA = {
    "stamp": {"sec": 1, "nanosec": 2},
    "frame_id": "world_center_optical_frame",
    "frame_number": 7,
    "exposure_ns": 3_250_000,
    "analog_gain": 2.5,
    "intrinsics": {
        "width": 1016,
        "height": 1016,
        "focal_length": [569.05, 570.92],
        "principal_point": [508.5, 507.25],
        "distortion_model": "fisheye_tangential",
        "distortion": [0.125, -0.02, 0.003, -0.0004, 0.00011, -0.00012],
    },
}


def test_metadata_is_text_with_its_names_and_all_digits() -> None:
    assert metadata_text(json.dumps(METADATA)).splitlines() == [
        "AnalogGain: 2.5",
        "ExposureTime: 3.25",
        "Focal Length: (569.05, 570.92)",
        "Principal Point: (508.5, 507.25)",
        "Radial Distortion: [0.125,-0.02,0.003,-0.0004]",
        "Tangential Distortion: [0.00011,-0.00012]",
    ]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "null",
        '{"intrinsics": {}}',
        '{"exposure_ns": "x"}',
        f'{{"exposure_ns": {10**400}}}',
    ],
)
def test_what_is_no_metadata_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"metadata|Expecting value"):
        metadata_text(text)


def test_the_configuration_has_its_shape_and_is_what_runs() -> None:
    """It had every section of its file, whether that was enabled or not."""
    values = {"stream": 0, "update_rate": 15, "resolution_width": 1280, "backend": "camera2"}
    applied = {
        "headset": "h",
        "session": "s",
        "streams": {
            "color": {"result": "adjusted", "values": values, "reason": "x", "topics": []},
            "world_left": {"result": "refused", "values": None, "reason": "x", "topics": []},
        },
    }
    found = json.loads(configuration_text(json.dumps(applied), "/magic_leap2"))
    assert found["general"] == {"topic_name": "/magic_leap2"}
    assert found["picture_center"] == {
        "enabled": True,
        "stream": 0,
        "resolution_width": 1280,
        "resolution_height": 1080,
        "update_rate": 15,
        "format": "jpeg",
    }
    assert found["world_left"]["enabled"] is False
    assert found["world_left"]["format"] == "Grayscale"
    assert found["depth_center"]["format"] == "Depth32"
    assert found["other_sensors"] == {"enabled": False}
    assert len(found) == 11


PROGRAM = """
import json, sys, rclpy
from sensor_msgs.msg import Imu
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("old_program")
def say(*words): print(json.dumps(words), flush=True)
def described(it): say("metadata", it.data)
node.create_subscription(String, "/thesis/world_center/metadata", described, 10)
node.create_subscription(
    Imu,
    "/thesis/gyro/imu",
    lambda it: say(it.header.frame_id, it.angular_velocity.x, it.angular_velocity.y),
    10,
)
node.create_subscription(String, "/MagicLeap/config", lambda it: say("config", it.data), 10)
request = node.create_publisher(String, "/request", 10)
node.create_timer(0.2, lambda: request.publish(String(data="REQUEST")))
rclpy.spin(node)
"""


@pytest.fixture
def compat() -> Iterator[Child]:
    with Child("-m", "ml2_receiver", "compat") as child:
        assert child.line() == "ready to republish topics of /magic_leap2 below /thesis"
        yield child


def test_an_old_program_gets_its_topics(device: MockDevice, compat: Child) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")

    header = ros_messages.header("imu_left_frame", 3)
    imu = ros_messages.imu(header, (1.0, 2.0, 0.0), (0.0, 0.0, 0.0))

    def publish() -> None:
        device.publish("world_center/metadata", encode_string(json.dumps(METADATA)))
        device.publish("gyro_left/imu", imu)

    seen: dict[str, list[object]] = {}
    with Child("-c", PROGRAM) as program, repeated(publish, 0.05):
        while seen.keys() != {"metadata", "magicleap_gyro", "config"}:
            kind, *values = program.object()
            seen[kind] = values
    assert "AnalogGain: 2.5" in str(seen["metadata"][0])
    assert seen["magicleap_gyro"] == [2.0, -1.0]
    assert json.loads(str(seen["config"][0]))["world_center"]["enabled"] is True
    assert compat.end() == 0
    # The program may ask before the configuration has arrived.
    assert [it for it in compat.errors if "no headset was configured yet" not in it] == []
