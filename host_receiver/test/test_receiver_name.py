"""A receiver's name, its node's namespace and its node's name, as ROS's arguments give them."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from socket import gethostname

import pytest

from configurations import only
from mock_device import MockDevice
from ros_processes import Child, Receiver, Subscriber
from waiting import await_true

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("world_left: {enabled: true}")
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
        (["--ros-args", "-r", "other:__ns:=/robot1", "-r", "other:__node:=it"], ""),
        (["--ros-args", "-r", "__node:=it", "-r", "it:__ns:=/robot1"], "robot1"),
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


pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("world_left: {enabled: true}")
_SAID = "Start each with a --name of its own"


@contextmanager
def two(config: Path, first: list[str], second: list[str]) -> Iterator[tuple[Receiver, Receiver]]:
    with Receiver(config, *first) as one, Receiver(config, *second) as other:
        yield one, other


def said(receiver: Receiver) -> list[str]:
    return [line for line in receiver.errors if _SAID in line]


def tool(*words: str) -> tuple[str, list[str]]:
    """Runs a command, which succeeds; returns its first line and what it says of errors."""
    with Child("-m", "ml2_receiver", *words) as child:
        line = child.line()
        assert child.wait() == 0, child.errors
        return line, child.errors


@pytest.mark.parametrize(
    ("first", "second", "what"),
    [
        ([], [], "another receiver without a name"),
        (["--name", "robot1"], ["--ros-args", "-r", "__ns:=/robot1"], "receiver named robot1"),
        ([], ["--ros-args", "-r", "__node:=headset"], "/headset publishes /magic_leap2/config"),
    ],
)
def test_both_say_that_they_have_one_name(
    config: Path, first: list[str], second: list[str], what: str
) -> None:
    with two(config, first, second) as (one, other):
        one.await_error(_SAID)
        other.await_error(_SAID)
        assert what in said(one)[0]
        assert "WARN" in said(one)[0]


def test_a_setting_that_two_get_names_both(config: Path) -> None:
    with two(config, [], []) as (one, other):
        one.await_error(_SAID)
        names = [f"{gethostname()} (pid {it.process.pid})" for it in (one, other)]

        def both_are_named() -> bool:
            """False while the tool has not found both in its short life."""
            line, errors = tool("set", "battery.enabled=true")
            is_told = any("2 receivers have the name /ml2_receiver" in it for it in errors)
            return is_told and all(it in line for it in names)

        await_true(both_are_named)
        for it in (one, other):  # and so it is
            with MockDevice(it.address, says_ping=True) as device:
                assert "battery" in device.reach_configure().streams
        assert len(said(one)) == 1


def test_receivers_with_names_of_their_own_say_nothing_and_tools_say_whom_they_reached(
    config: Path,
) -> None:
    with two(config, ["--name", "robot1"], []) as (one, other):
        # A tool that has not found the other receiver in its short life cannot say whom it reached.
        await_true(lambda: tool("call", "stop", "--name", "robot1")[0].startswith("/robot1/"))
        await_true(lambda: tool("set", "battery.enabled=true") == ("/ml2_receiver: done", []))
        assert said(one) == said(other) == []


def test_a_receiver_alone_is_not_named(config: Path) -> None:
    with Receiver(config):
        assert tool("set", "battery.enabled=true") == ("done", [])
