"""`ml2-receiver record` as a process: killed, on a full disk, with ROS and without."""

import itertools
import resource
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from rosbags.rosbag2 import Reader

import bag_scene
from bag_readers import (
    READERS,
    Seen,
    digest,
    mcap_file,
    with_javascript_sequentially,
    with_mcap,
    with_mcap_sequentially,
    with_rosbags,
)
from bags import message_counts
from configurations import only
from ml2_tools.bags.bag_reader import BagReader
from mock_device import MockDevice
from repeated import repeated
from ros_processes import Child, Recording, Subscriber
from terminal import OnTerminal
from waiting import LIMIT_S, await_true

CONFIG = only("world_left: {enabled: true}, battery: {enabled: true}")
IMAGE = "world_left/image_raw"
_PERIOD_S = 0.005


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "walk"


@contextmanager
def started(folder: Path, config: Path, *options: str) -> Iterator[tuple[Recording, MockDevice]]:
    """A recording, and a headset that streams into it."""
    with (
        Recording(folder, config, *options) as recording,
        MockDevice(recording.address, says_ping=True) as device,
    ):
        device.start()
        yield recording, device


@contextmanager
def streaming(device: MockDevice) -> Iterator[list[str]]:
    """Image by image, until the receiver is gone; the digests of those that were sent."""
    sent: list[str] = []

    def stream() -> None:
        image = bag_scene.image(len(sent))
        with suppress(OSError):
            device.publish(IMAGE, image)
            sent.append(digest(image))

    with repeated(stream, _PERIOD_S):
        yield sent


def images_in(folder: Path, read: Callable[[Path], list[Seen]]) -> list[str]:
    return [seen.sha256 for seen in read(folder) if seen.topic.endswith(IMAGE)]


def await_flushed(folder: Path, count: int) -> None:
    """Waits until the file has so many bytes and metadata.yaml lists the topics."""
    file, metadata = mcap_file(folder), folder / "metadata.yaml"
    await_true(lambda: file.stat().st_size >= count and "battery" in metadata.read_text())


@pytest.mark.parametrize("flushed_bytes", [10_000, 2_000_000])
def test_a_kill_costs_nothing_that_was_flushed(
    folder: Path, config: Path, flushed_bytes: int
) -> None:
    with (
        started(folder, config, "--no-ros") as (recording, device),
        streaming(device) as sent,
    ):
        await_flushed(folder, flushed_bytes)
        due = len(sent)
        await_true(lambda: len(images_in(folder, with_mcap_sequentially)) >= max(due, 1))
        recording.process.kill()
        recording.wait()
    expected = [*sent, digest(bag_scene.image(len(sent)))]
    for read in (with_javascript_sequentially, with_mcap_sequentially):
        found = images_in(folder, read)
        assert found == expected[: len(found)]
        assert len(found) >= max(due, 1)
    reader = BagReader(folder)
    assert [digest(m.payload) for m in reader.messages() if m.topic.endswith(IMAGE)] == found
    assert "/magic_leap2/battery" in (folder / "metadata.yaml").read_text()


def publish_until_seen(device: MockDevice, subscriber: Subscriber) -> int:
    """Returns how many it took; those before discovery are lost."""
    for number in itertools.count():
        device.publish("battery", bag_scene.battery(number))
        if subscriber.has_line(0.1):
            break
    return number + 1


def test_it_publishes_what_it_records(folder: Path, config: Path) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    with started(folder, config) as (recording, device):
        with Subscriber("/magic_leap2/battery", "sensor_msgs/msg/BatteryState") as subscriber:
            published = publish_until_seen(device, subscriber)
        device.leave()
        assert recording.end() == 0
        assert recording.line().startswith("recorded ")
    for read in (with_rosbags, with_mcap):
        found = [seen.sha256 for seen in read(folder) if seen.topic.endswith("battery")]
        assert found == [digest(bag_scene.battery(number)) for number in range(published)]


def test_without_ros_it_says_who_came_and_what_runs(folder: Path, config: Path) -> None:
    with Recording(folder, config, "--no-ros") as recording:
        with MockDevice(recording.address) as device:
            device.start(refused={"world_left": "no permission"})
            device.leave()
        assert recording.end(signal.SIGTERM) == 0
        assert recording.line().endswith("0 dropped, 0 lost before the receiver")
    said = "\n".join(recording.errors)
    assert "world_left refused: 'no permission'" in said
    assert "streams: battery, tf" in said


WITHOUT_ROS = """
import sys
from ml2_receiver.cli import main
print(main(sys.argv[1:]), [name for name in sys.modules if name.startswith("rclpy")])
"""


def test_without_ros_nothing_of_ros_is_needed(folder: Path, config: Path) -> None:
    listen = ("--listen", "127.0.0.1:0", "--insecure")
    options = (str(folder), "--no-ros", "--config", str(config), *listen)
    with Child("-c", WITHOUT_ROS, "record", *options) as child:
        address = child.line().removeprefix("listening on ")
        with MockDevice(address) as device:
            device.start()
            device.publish("battery", bag_scene.battery(0))
            device.leave()
        child.end()
        lines = [child.line() for _ in range(3)]
    assert lines[-1] == "0 []"
    assert any(seen.topic.endswith("battery") for seen in with_mcap(folder))


def test_on_a_terminal_it_shows_how_it_goes(folder: Path, config: Path) -> None:
    options = (str(folder), "--no-ros", "--config", str(config), "--listen", "127.0.0.1:0")
    with OnTerminal("record", *options) as recording:
        recording.await_shown(b"MB/s")
        recording.process.send_signal(signal.SIGINT)
        recording.read_to_the_end()
        assert recording.process.wait(LIMIT_S) == 0


def test_it_says_what_is_missing_and_how_long_the_recording_is(folder: Path, config: Path) -> None:
    with Recording(folder, config, "--no-ros") as recording:
        with MockDevice(recording.address, says_ping=True) as device:
            device.start()
            device.publish(IMAGE, bag_scene.image(0))
            device.publish(IMAGE, bag_scene.image(3), skip=2)
            device.publish("battery", bag_scene.battery(0))
            device.leave()
            recording.await_error("session ended")
        assert recording.end() == 0
        words, missing = recording.line(), recording.line()
    with Reader(folder) as reader:
        duration_s = (reader.end_time - reader.start_time) / 1e9
    assert words.startswith(f"recorded into {folder}: {duration_s:.1f} s, ")
    assert words.endswith(" 0 dropped, 2 lost before the receiver")
    assert missing == f"  /magic_leap2/{IMAGE}: 0 dropped, 2 lost before the receiver"


def test_it_records_for_the_time_that_was_asked_for(folder: Path, config: Path) -> None:
    with (
        Recording(folder, config, "--no-ros", "--duration", "0.1") as recording,
        MockDevice(recording.address) as device,
    ):
        device.greet()  # the event of which is the first message
        assert recording.wait() == 0


def test_it_records_the_topics_that_were_asked_for(folder: Path, config: Path) -> None:
    chosen = ("--topic", "world_left/*", "--topic", "/tf")
    with started(folder, config, "--no-ros", *chosen) as (recording, device):
        device.publish("battery", bag_scene.battery(0))
        with streaming(device):
            await_true(lambda: message_counts(folder).get(f"/magic_leap2/{IMAGE}", 0) > 0)
            assert recording.end() == 0
    topics = BagReader(folder).types.keys()
    camera = {f"/magic_leap2/world_left/{it}" for it in ("image_raw", "camera_info", "metadata")}
    assert topics == {"/magic_leap2/config", "/magic_leap2/log", "/tf", *camera}
    assert any(seen.topic.endswith(IMAGE) for seen in with_rosbags(folder))


def limit_files(process: int, size: int) -> None:
    """Limits the size of files, which acts as a full disk does."""
    resource.prlimit(process, resource.RLIMIT_FSIZE, (size, size))


def test_on_a_full_disk_the_recording_ends_and_the_topics_go_on(folder: Path, config: Path) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    with started(folder, config) as (recording, device):
        with Subscriber("/magic_leap2/battery", "sensor_msgs/msg/BatteryState") as subscriber:
            limit_files(recording.process.pid, 500_000)
            with streaming(device):
                recording.await_error("the recording has ended: File too large")
            publish_until_seen(device, subscriber)
        device.leave()
        assert recording.end() == 2
    check_images(folder)


def check_images(folder: Path) -> None:
    """Readers that go by the index find the first images, whole."""
    for read in READERS:
        images = [seen.sha256 for seen in read(folder) if seen.topic.endswith(IMAGE)]
        assert images == [digest(bag_scene.image(number)) for number in range(len(images))]
        assert images


def test_a_folder_that_is_removed_ends_the_recording(folder: Path, config: Path) -> None:
    with started(folder, config, "--no-ros") as (recording, device):
        bag_scene.remove(folder)
        with streaming(device):
            assert recording.wait() == 2
        error, hint = recording.errors[-2:]
        assert "the recording has ended: somebody has removed its file" in error
        assert hint.startswith("hint: Leave the folder in place")


def test_on_a_full_disk_without_ros_it_ends(folder: Path, config: Path) -> None:
    with started(folder, config, "--no-ros") as (recording, device):
        limit_files(recording.process.pid, 500_000)
        with streaming(device):
            assert recording.wait() == 2
        assert "the recording has ended: File too large" in recording.errors[-2]
        assert recording.errors[-1].startswith("hint: Leave the folder in place")
        assert mcap_file(folder).stat().st_size <= 500_000
    check_images(folder)
