"""Recordings that begin and end while a receiver runs."""

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

import bag_scene
from bag_readers import digest, with_mcap, with_rosbags
from configurations import only
from ml2_tools.bags.bag_reader import BagReader
from mock_device import MockDevice
from ros_processes import Child, Client, Receiver

pytest.importorskip("rclpy", reason="rclpy is not installed")

from ml2_tools.live.diagnostics import Rows, Values
from ml2_tools.live.diagnostics_node import DiagnosticsNode
from waiting import LIMIT_S

CONFIG = only("world_left: {enabled: true}, battery: {enabled: true}")
BATTERY, IMAGE = "/magic_leap2/battery", "/magic_leap2/world_left/image_raw"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "walk"


def images(folder: Path) -> list[str]:
    return [seen.sha256 for seen in with_mcap(folder) if seen.topic == IMAGE]


def rows(is_true: Callable[[Rows], bool]) -> Rows:
    """Returns the rows of /diagnostics once they satisfy `is_true`."""
    watch = DiagnosticsNode()
    try:
        return watch.rows("", LIMIT_S, is_true)
    finally:
        watch.close()


def await_received(**counts: str) -> Rows:
    """Waits until so many have arrived of each."""
    topics = {BATTERY: counts.get("batteries"), IMAGE: counts.get("images")}
    return rows(
        lambda found: all(
            count is None or found.get(topic, {}).get("received") == count
            for topic, count in topics.items()
        )
    )


def recording(state: str) -> Values:
    """The row of the recording, once it is in this state."""
    return rows(lambda found: found.get("recording", {}).get("state") == state)["recording"]


def test_a_recording_that_begins_late_has_what_is_open(
    ros_of_children: None, folder: Path, device: MockDevice, client: Client
) -> None:
    device.publish("world_left/image_raw", bag_scene.image(0), skip=3)
    await_received(images="1")
    assert client.ask("set_atomically", {"record.folder": str(folder)}) == [True, ""]
    assert client.ask("trigger", "start_recording") == [True, f"recording into {folder}"]
    device.publish("world_left/image_raw", bag_scene.image(1), skip=2)
    device.publish("battery", bag_scene.battery(1))
    found = await_received(images="2", batteries="1")["recording"]
    assert (found["state"], found["lost"], found["dropped"]) == ("recording", "2", "0")
    assert found[f"lost.{IMAGE}"] == "2"
    is_done, words = client.ask("trigger", "stop_recording")
    assert (is_done, "0 dropped, 2 lost before the receiver" in words) == (True, True)
    device.publish("world_left/image_raw", bag_scene.image(2))
    assert images(folder) == [digest(bag_scene.image(1))]
    assert BagReader(folder).config.headset == "device name"
    assert recording("ended")["lost"] == "2"


def test_one_recording_at_a_time_and_none_over_another(
    folder: Path, device: MockDevice, client: Client
) -> None:
    assert client.ask("trigger", "stop_recording") == [False, "no recording is on"]
    client.ask("set_atomically", {"record.folder": str(folder), "record.topics": "battery"})
    assert client.ask("trigger", "start_recording")[0]
    assert client.ask("trigger", "start_recording") == [
        False,
        f"a recording into {folder} is on: ~/stop_recording",
    ]
    assert client.ask("trigger", "stop_recording")[0]
    assert BagReader(folder).types.keys() == {BATTERY, "/magic_leap2/config", "/magic_leap2/log"}
    assert client.ask("trigger", "start_recording") == [
        False,
        f"{folder} exists already. Set the parameter record.folder to another folder.",
    ]
    ((is_done, _),) = client.ask("set", {"record.split_size_mb": -1})
    assert not is_done
    client.ask("set", {"record.compression": "gzip"})
    is_done, words = client.ask("trigger", "start_recording")
    assert (is_done, "expected one of none, zstd, found 'gzip'" in words) == (False, True)


def test_a_recording_is_sent_what_nobody_subscribes_to(
    folder: Path, device: MockDevice, client: Client
) -> None:
    assert client.ask("set", {"publish.lazy": True}) == [[True, ""]]
    assert device.reconfigure().streams == {}
    client.ask("set", {"record.folder": str(folder)})
    assert client.ask("trigger", "start_recording")[0]
    asked = device.reconfigure()
    assert set(asked.streams) == {"world_left", "battery", "tf"}
    device.expect_start(asked.request)
    assert client.ask("trigger", "stop_recording")[0]
    assert device.reconfigure().streams == {}


def test_a_recording_ends_with_the_receiver(
    folder: Path, receiver: Receiver, device: MockDevice
) -> None:
    with Client() as client:
        client.ask("set", {"record.folder": str(folder)})
        assert client.ask("trigger", "start_recording")[0]
    device.publish("battery", bag_scene.battery(1))
    device.leave()
    receiver.await_error("session ended")
    assert receiver.end() == 0
    assert BATTERY in [seen.topic for seen in with_rosbags(folder)]


def test_the_command_records_beside_a_receiver_that_runs(
    ros_of_children: None, folder: Path, device: MockDevice
) -> None:
    command = ("-m", "ml2_receiver", "record", str(folder), "--attach", "--topic", "*/image_raw")
    with Child(*command) as child:
        assert child.line() == f"recording into {folder} until Ctrl-C"
        device.publish("world_left/image_raw", bag_scene.image(1), skip=2)
        device.publish("battery", bag_scene.battery(1))
        await_received(images="1", batteries="1")
        assert child.end() == 0
        words = child.line()
    assert words.startswith(f"recorded into {folder}: ")
    assert words.endswith("0 dropped, 2 lost before the receiver")
    assert images(folder) == [digest(bag_scene.image(1))]
    text = (folder / "metadata.yaml").read_text()
    duration_ns = yaml.safe_load(text)["rosbag2_bagfile_information"]["duration"]["nanoseconds"]
    assert f" {duration_ns / 1e9:.1f} s," in words
    assert BATTERY not in BagReader(folder).types


def test_the_command_ends_after_its_duration(folder: Path, device: MockDevice) -> None:
    command = ("-m", "ml2_receiver", "record", str(folder), "--attach", "--duration", "0.1")
    with Child(*command) as child:
        assert child.line() == f"recording into {folder} for 0.1 s, or until Ctrl-C"
        assert child.wait() == 0
    assert BagReader(folder).config.headset == "device name"


def test_a_recording_that_failed_is_told_and_another_may_begin(
    ros_of_children: None, folder: Path, receiver: Receiver, device: MockDevice, client: Client
) -> None:
    with Child("-m", "ml2_receiver", "record", str(folder), "--attach") as child:
        assert child.line() == f"recording into {folder} until Ctrl-C"
        bag_scene.remove(folder)
        assert child.wait() == 2
    assert "it ended early: somebody has removed its file" in child.errors[-1]
    assert any("the recording has ended: somebody" in line for line in receiver.errors)
    assert client.ask("trigger", "start_recording")[0]
    device.publish("battery", bag_scene.battery(1))
    bag_scene.remove(folder)
    assert "removed its file" in recording("failed")["message"]
    client.ask("set", {"record.folder": str(folder.parent / "again")})
    assert client.ask("trigger", "start_recording") == [
        True,
        f"recording into {folder.parent / 'again'}",
    ]
