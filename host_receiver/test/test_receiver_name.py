"""A receiver's name, its node's namespace and its node's name, as ROS's arguments give them."""

from pathlib import Path

import pytest

from mock_device import MockDevice
from ros_processes import Child, Receiver, Subscriber

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = "/ml2_receiver: {ros__parameters: {world_left: {enabled: true}}}"
_RUN = ("-m", "ml2_receiver", "run", "--listen", "127.0.0.1:0", "--insecure", "--config")


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (["--ros-args", "-r", "__ns:=/robot1"], "robot1"),
        (["--ros-args", "--remap", "ml2_receiver:__ns:=/robot1"], "robot1"),
        (["--name", "robot1", "--ros-args", "-r", "__ns:=/robot1"], "robot1"),
        (["--name", "robot1", "--ros-args", "-r", "__node:=headset"], "robot1"),
        (["--ros-args", "-r", "__node:=headset"], ""),
        (["--ros-args", "-r", "__ns:=/"], ""),
    ],
)
def test_topics_frames_and_tools_follow_the_node(
    config: Path, options: list[str], name: str
) -> None:
    prefix = f"/{name}/magic_leap2" if name else "/magic_leap2"
    with (
        Receiver(config, *options) as receiver,
        MockDevice(receiver.address, says_ping=True) as device,
    ):
        device.start()
        with Subscriber(f"{prefix}/world_left/camera_info", "sensor_msgs/msg/CameraInfo"):
            pass
        setting = ("-m", "ml2_receiver", "set", "battery.enabled=true")
        with Child(*setting, *(["--name", name] if name else [])) as tool:
            assert tool.wait() == 0, tool.errors
        assert "battery" in device.reconfigure().streams


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--name", "robot1", "--ros-args", "-r", "__ns:=/robot2"], "of two receivers"),
        (["--ros-args", "-r", "__ns:=/lab/robot1"], "cannot be a receiver's name"),
    ],
)
def test_a_contradiction_is_refused(config: Path, options: list[str], said: str) -> None:
    with Child(*_RUN, str(config), *options) as child:
        assert child.wait() == 2
    assert any(said in line for line in child.errors), child.errors
