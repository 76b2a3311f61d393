"""Tools beside a receiver whose topics ROS's arguments have moved."""

import argparse
from pathlib import Path

import pytest

import bag_scene
from command_line import refusal, with_subcommands
from configurations import only
from ml2_receiver import cli
from ml2_receiver.commands.ros_start import ros_args_of, topic_remappings
from mock_device import MockDevice
from repeated import repeated
from ros_processes import Child, Receiver

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("battery: {enabled: true}")


@pytest.mark.parametrize(
    ("receiver", "tool", "topic"),
    [
        (["-r", "/robot1/magic_leap2/battery:=/charge"], None, "battery"),
        (["-r", "/robot1/magic_leap2/battery:=charge"], None, "battery"),
        (["-r", "/robot1/magic_leap2/battery:=charge"], ["-r", "__ns:=/robot1"], "battery"),
    ],
)
def test_a_tool_with_the_arguments_of_the_receiver_finds_its_topics(
    config: Path, receiver: list[str], tool: list[str] | None, topic: str
) -> None:
    name = ["--name", "robot1"]
    with (
        Receiver(config, *name, "--ros-args", *receiver) as running,
        MockDevice(running.address, says_ping=True) as device,
    ):
        device.start()
        given = [*(name if tool is None else ()), "--ros-args", *receiver, *(tool or ())]
        echo = ("-m", "ml2_receiver", "echo", topic, "--once", *given)
        with (
            repeated(lambda: device.publish("battery", bag_scene.battery(1)), 0.05),
            Child(*echo) as child,
        ):
            assert child.line() == "header:", child.errors
            assert child.wait() == 0


def test_every_command_that_has_a_node_takes_arguments_of_ros() -> None:
    without = {"calibrate", "config", "headset", "inspect", "messages", "pair", "play", "rviz"}
    without |= {"unpair"}
    for words, parser in with_subcommands(("ml2-receiver",), cli.command_line()):
        if len(words) == 2:
            takes = any("--ros-args" in it.option_strings for it in parser._actions)
            assert takes == (words[1] not in without), words


@pytest.mark.parametrize("given", ["-r /tf:=tf", "-p battery.enabled:=true", "--log-level debug"])
@pytest.mark.parametrize("command", ["run --zenoh tcp/127.0.0.1:1", "record nowhere"])
def test_what_only_a_node_takes_is_refused_without_one(command: str, given: str) -> None:
    words = [*command.split(), "--no-ros", "--ros-args", "-r", "__ns:=/robot1", *given.split()]
    assert f"--no-ros makes no node that takes {given.removeprefix('-r ')}" in refusal(*words)


def test_without_a_node_the_namespace_is_the_name() -> None:
    options = argparse.Namespace(
        name="", no_ros=True, ros_args=["-r", "__node:=it", "--ros-args", "-r", "__ns:=/robot1"]
    )
    with ros_args_of(options):
        assert options.name == "robot1"


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        (["-r", "/tf:=tf", "--remap", "a:=b"], ["-r", "/tf:=tf", "-r", "a:=b"]),
        (["-r", "ml2_receiver:/tf:=tf"], ["-r", "/tf:=tf"]),
        (["-r", "__node:=it", "-r", "it:__ns:=/robot1", "-p", "x:=1", "--log-level", "debug"], []),
        ([], []),
    ],
)
def test_the_page_beside_a_receiver_follows_its_topics_alone(
    given: list[str], kept: list[str]
) -> None:
    assert topic_remappings(given) == kept
