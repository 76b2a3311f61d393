"""Commands in place of `ros2 param`, `service` and `topic` where `ros2` is missing."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import bag_scene
from command_line import refusal
from configurations import only
from ml2_receiver.cli import main
from ml2_receiver.configuration.config import load_config
from mock_device import MockDevice
from repeated import repeated
from ros_processes import Child, Client, environment
from waiting import LIMIT_S

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("battery: {enabled: true}, world_left: {enabled: true}")
REFUSED = {
    "picture_center.update_rate=45": "expected update_rate to be one of",
    "world_left.enabled=perhaps": 'expected true or false, found "perhaps"',
    "world_up.enabled=true": "world_up",
    "general.topic_name=/other": "general.topic_name",
}


def echo(*arguments: str) -> tuple[int, list[str], str]:
    """Exit code, lines, and what it said to standard error."""
    done = subprocess.run(
        [sys.executable, "-m", "ml2_receiver", "echo", *arguments],
        env=environment(),
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    return done.returncode, done.stdout.splitlines(), done.stderr


type Command = Callable[..., tuple[int, list[str], str]]


@pytest.fixture
def command(ros_of_children: None, capsys: pytest.CaptureFixture[str]) -> Command:
    """Runs a command in this process, and returns what `echo` does."""

    def run(*arguments: str) -> tuple[int, list[str], str]:
        code = main(arguments)
        said = capsys.readouterr()
        return code, said.out.splitlines(), said.err

    return run


def test_values_that_are_legal_together_are_set_together(client: Client, command: Command) -> None:
    pairs = {"resolution_width": 1280, "resolution_height": 720, "update_rate": 60}
    values = [f"picture_center.{key}={value}" for key, value in pairs.items()]
    code, _, said = command("set", *values, "picture_center.enabled=true")
    assert (code, said) == (0, "")
    keys = [f"picture_center.{key}" for key in (*pairs, "enabled")]
    assert client.ask("get", *keys) == [1280, 720, 60, True]


@pytest.mark.usefixtures("receiver")
def test_a_value_that_is_refused_is_refused_with_the_receivers_words(command: Command) -> None:
    for value, words in REFUSED.items():
        code, _, said = command("set", value)
        assert (code, words in said) == (2, True), (value, said)


def test_what_is_no_assignment_is_refused() -> None:
    assert "expected KEY=VALUE, found 'world_left.enabled'" in refusal("set", "world_left.enabled")


def test_services_are_called(device: MockDevice, command: Command) -> None:
    code, lines, _ = command("call", "stop")
    assert (code, lines) == (0, ["streams are stopped until ~/start"])
    assert device.reconfigure().streams == {}


def test_keys_are_saved_by_name(client: Client, command: Command, config: Path) -> None:
    assert client.ask("set_atomically", {"tf.layout": "rig", "gaze.enabled": True})[0]
    code, _, said = command("call", "save_config")
    assert (code, "not as in the file are gaze.enabled, tf.layout" in said) == (2, True)
    assert command("call", "save_config", "tf.layout") == (0, [f"written to {config}"], "")
    assert load_config(config).values["tf.layout"] == "rig"
    assert not load_config(config).values["gaze.enabled"]
    code, _, said = command("call", "stop", "tf.layout")
    assert (code, "stop takes no keys" in said) == (2, True)


def test_messages_are_printed_with_the_first_elements_of_long_arrays(device: MockDevice) -> None:
    with repeated(lambda: device.publish("world_left/image_raw", bag_scene.image(3)), 0.05):
        code, lines, said = echo("world_left/image_raw", "--once")
    assert (code, said) == (0, "")
    assert lines[:3] == [
        "header:",
        "  stamp: {sec: 3, nanosec: 5}",
        "  frame_id: world_left_optical_frame",
    ]
    assert "encoding: mono8" in lines
    assert any("... 3072 in all" in line for line in lines)
    assert lines[-1] == "---"


def test_what_was_said_before_is_printed_where_ros_keeps_it(device: MockDevice) -> None:
    code, lines, _ = echo("/magic_leap2/config", "--once")
    assert code == 0
    assert "world_left" in "".join(lines)


def test_echo_names_the_nearest_topic_at_once() -> None:
    with Child("-m", "ml2_receiver", "echo", "ligth_sensor") as child:
        child.await_error("no sensor has the topic ligth_sensor; did you mean light_sensor?")
        assert child.process.poll() is None, "another node may publish it yet"


@pytest.mark.usefixtures("receiver")
def test_echo_names_the_nearest_topic_of_another_node_in_the_end() -> None:
    code, lines, said = echo("/diagnostic")
    assert (code, lines) == (2, [])
    assert "/diagnostic has no publisher after 10 s; did you mean /diagnostics?" in said
