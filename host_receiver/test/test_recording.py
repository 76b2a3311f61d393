"""Recordings, as readers that are not ours see them."""

import json
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.interfaces import QosDurability, QosHistory, QosReliability
from rosbags.rosbag2 import Reader

import bag_scene
from bag_readers import READERS, Seen, digest, mcap_file, with_javascript, with_mcap, with_rosbags
from ml2_receiver.errors import PublishError, RecordingError
from ml2_receiver.generated.type_hashes import HASHES
from ml2_receiver.recording.bag_folder import make_folder
from ml2_receiver.recording.bag_topic import BagTopic
from ml2_receiver.recording.recorder import QUEUE_BYTES, Recorder
from ml2_receiver.session.sink import Applied
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Qos
from ml2_receiver.wire.messages import StreamAnswer
from ml2_tools.bags.bag_reader import Bag, BagReader

COUNT = 40
BATTERY = load_table().streams["battery"].topics[0]


@pytest.fixture(scope="module", params=["none", "zstd"])
def recording(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags") / f"walk_{request.param}"
    bag_scene.record(folder, COUNT, request.param)
    return folder


def make_recorder(folder: Path, queue_bytes: int = QUEUE_BYTES) -> Recorder:
    return Recorder(
        bag_scene.new_writer(folder), load_table(), bag_scene.PREFIX, pytest.fail, queue_bytes
    )


@pytest.mark.parametrize("read", READERS)
def test_every_payload_is_recorded_as_it_was_sent(
    recording: Path, read: Callable[[Path], list[Seen]]
) -> None:
    by_topic = defaultdict(list)
    for seen in read(recording):
        by_topic[seen.topic].append(seen)
    for name, (type, make) in bag_scene.SENT.items():
        topic = bag_scene.absolute(name)
        assert by_topic[topic] == [
            Seen(topic, type, (number, 5), digest(make(number))) for number in range(COUNT)
        ]


def test_events_and_the_configuration_are_recorded_too(recording: Path) -> None:
    reader = BagReader(recording)
    assert reader.config.headset == "device name"
    assert reader.config.streams["battery"].topics[0].topic == "/magic_leap2/battery"
    log = [message for message in reader.messages() if message.topic == "/magic_leap2/log"]
    assert any(b"streams: world_left, battery, tf" in message.payload for message in log)


def test_the_metadata_is_what_jazzy_writes(recording: Path) -> None:
    text = (recording / "metadata.yaml").read_text()
    metadata = yaml.safe_load(text)["rosbag2_bagfile_information"]
    assert metadata["version"] == 9
    assert (metadata["storage_identifier"], metadata["ros_distro"]) == ("mcap", "jazzy")
    assert metadata["relative_file_paths"] == [mcap_file(recording).name]
    assert metadata["files"][0]["message_count"] == metadata["message_count"] > 3 * COUNT
    assert not any(sign in text for sign in ("&id", "*id")), "yaml-cpp may not know references"
    with Reader(recording) as reader:
        times = [time for _, time, _ in reader.messages()]
        assert (reader.start_time, reader.end_time) == (times[0], times[-1] + 1)
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
    assert {counts[bag_scene.absolute(name)] for name in bag_scene.SENT} == {COUNT}


@pytest.mark.parametrize(
    ("topic", "depth", "durability"),
    [
        ("/magic_leap2/config", 1, QosDurability.TRANSIENT_LOCAL),
        ("/magic_leap2/world_left/image_raw", 5, QosDurability.VOLATILE),
        ("/tf", 100, QosDurability.VOLATILE),
    ],
)
def test_the_quality_of_service_is_that_of_the_publishers(
    recording: Path, topic: str, depth: int, durability: QosDurability
) -> None:
    with Reader(recording) as reader:
        (connection,) = (found for found in reader.connections if found.topic == topic)
    (qos,) = connection.ext.offered_qos_profiles  # type: ignore[union-attr]
    assert (qos.history, qos.reliability) == (QosHistory.KEEP_LAST, QosReliability.RELIABLE)
    assert (qos.depth, qos.durability) == (depth, durability)


def test_static_transforms_stay_for_late_subscribers(tmp_path: Path) -> None:
    (row,) = (row for row in load_table().streams["tf"].topics if row.role == "tf_static")
    static = BagTopic(row.name, row.type, load_table().qos[row.qos])
    writer = bag_scene.new_writer(tmp_path / "walk", static)
    writer.write(static, 1, bag_scene.tf(0))
    writer.close()
    with Reader(tmp_path / "walk") as reader:
        (qos,) = reader.connections[0].ext.offered_qos_profiles  # type: ignore[union-attr]
    assert qos.durability == QosDurability.TRANSIENT_LOCAL


def test_a_type_without_a_known_definition_is_recorded_all_the_same(tmp_path: Path) -> None:
    custom = BagTopic("/magic_leap2/custom/thing", "my_msgs/msg/Thing", load_table().qos["sensor"])
    writer = bag_scene.new_writer(tmp_path / "walk", custom)
    writer.write(custom, 7, b"\0\1\0\0payload!")
    writer.close()
    with mcap_file(tmp_path / "walk").open("rb") as file:
        ((schema, channel, message),) = make_reader(file).iter_messages()
    assert schema is not None
    assert (schema.name, schema.encoding, schema.data) == ("my_msgs/msg/Thing", "", b"")
    assert (channel.topic, message.data) == (custom.name, b"\0\1\0\0payload!")
    with Reader(tmp_path / "walk") as reader:
        assert [found.msgtype for found in reader.connections] == ["my_msgs/msg/Thing"]


def test_type_hashes_are_those_of_the_installed_ros() -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    prefixes = os.environ.get("AMENT_PREFIX_PATH", sys.prefix).split(":")
    for type, expected in HASHES.items():
        package, _, name = type.partition("/msg/")
        files = [Path(prefix, "share", package, "msg", f"{name}.json") for prefix in prefixes]
        description = next(file for file in files if file.exists()).read_text()
        assert json.loads(description)["type_hashes"][0] == {
            "type_name": type,
            "hash_string": expected,
        }


def test_a_changed_byte_is_found_by_its_crc(tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    bag_scene.record(folder, 3)
    data = bytearray(mcap_file(folder).read_bytes())
    pixels = bag_scene.image(1)[-100:]
    data[data.index(pixels)] ^= 1
    mcap_file(folder).write_bytes(data)
    for read in (with_mcap, with_javascript):
        with pytest.raises(ValueError, match=r"(?i)crc"):
            read(folder)
    with pytest.raises(RecordingError, match="is broken: crc"):
        list(BagReader(folder).messages())


def test_the_buffer_of_a_payload_may_be_used_again_at_once(tmp_path: Path) -> None:
    recorder = make_recorder(tmp_path / "walk")
    publish = recorder.open(BATTERY)
    payload = bytearray(bag_scene.battery(1))
    publish(payload)
    payload[:] = bag_scene.battery(2)
    recorder.close()
    (message,) = (seen for seen in with_mcap(tmp_path / "walk") if seen.topic.endswith("battery"))
    assert message.sha256 == digest(bag_scene.battery(1))


def test_what_the_disk_is_too_slow_for_is_refused_and_counted(tmp_path: Path) -> None:
    recorder = make_recorder(tmp_path / "walk", queue_bytes=2000)
    publish = recorder.open(BATTERY)
    with pytest.raises(PublishError, match="too slow"):
        publish(bytearray(2000))
    publish(bytearray(bag_scene.battery(1)))
    recorder.close()
    assert recorder.progress.dropped == {"/magic_leap2/battery": 1}
    assert recorder.progress.messages == 1
    assert [seen.topic for seen in with_mcap(tmp_path / "walk")] == ["/magic_leap2/battery"]


def test_a_topic_that_has_ended_takes_nothing_until_it_is_opened_again(tmp_path: Path) -> None:
    recorder = make_recorder(tmp_path / "walk")
    publish = recorder.open(BATTERY)
    applied = Applied("headset", "session", {"battery": StreamAnswer("refused", None, "why")}, [])
    recorder.configured(applied)
    publish(bytearray(bag_scene.battery(1)))
    recorder.open(BATTERY)(bytearray(bag_scene.battery(2)))
    recorder.close()
    seen = [seen for seen in with_mcap(tmp_path / "walk") if seen.topic.endswith("battery")]
    assert [one.sha256 for one in seen] == [digest(bag_scene.battery(2))]


def test_a_recording_of_nothing_can_be_opened(tmp_path: Path) -> None:
    make_recorder(tmp_path / "walk").close()
    assert with_mcap(tmp_path / "walk") == with_javascript(tmp_path / "walk") == []
    with Reader(tmp_path / "walk") as reader:
        assert reader.message_count == 0


def test_a_folder_that_exists_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="exists already"):
        make_folder(tmp_path, is_overwriting=False)


def test_an_earlier_recording_is_replaced_when_asked_for(tmp_path: Path) -> None:
    make_recorder(tmp_path / "walk").close()
    make_folder(tmp_path / "walk", is_overwriting=True)
    assert list((tmp_path / "walk").iterdir()) == []


@pytest.mark.parametrize("is_folder", [True, False])
def test_only_recordings_are_replaced(tmp_path: Path, is_folder: bool) -> None:
    precious = tmp_path / "walk" / "thesis.tex" if is_folder else tmp_path / "walk"
    precious.parent.mkdir(exist_ok=True)
    precious.write_text("precious")
    with pytest.raises(RecordingError, match=f"more than a recording .* found '{precious.name}'"):
        make_folder(tmp_path / "walk", is_overwriting=True)
    assert precious.exists()


def test_a_long_recording_goes_on_in_another_file(tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    topic = BagTopic("/battery", BATTERY.type, Qos(10))
    writer = bag_scene.new_writer(folder, topic, split_ns=2)
    for number in range(7):
        writer.write(topic, number, bag_scene.battery(number))
        writer.flush()
    writer.close()
    names = [f"walk_{number}.mcap" for number in range(3)]
    assert sorted(file.name for file in folder.glob("*.mcap")) == names
    metadata = yaml.safe_load((folder / "metadata.yaml").read_text())
    found = metadata["rosbag2_bagfile_information"]
    assert found["relative_file_paths"] == names
    assert [file["message_count"] for file in found["files"]] == [3, 3, 1]
    assert (found["message_count"], found["duration"]["nanoseconds"]) == (7, 6)
    expected = [digest(bag_scene.battery(number)) for number in range(7)]
    assert [seen.sha256 for seen in with_rosbags(folder)] == expected
    assert [digest(message.payload) for message in Bag(folder).messages()] == expected


def test_a_large_recording_goes_on_in_another_file(tmp_path: Path) -> None:
    topic = BagTopic("/battery", BATTERY.type, Qos(10))
    writer = bag_scene.new_writer(tmp_path / "walk", topic, split_bytes=10_000)
    for number in range(3):
        writer.write(topic, number, bytes(6_000))
        writer.flush()
    assert [file.message_count for file in writer.metadata.files] == [2, 1]
    writer.close()


def test_the_folder_may_be_thousands_of_folders_deep(tmp_path: Path) -> None:
    deep = tmp_path.joinpath(*"d" * 1500)
    try:
        make_folder(deep, is_overwriting=False)
        assert deep.is_dir()
    finally:  # pytest could not remove it
        subprocess.run(["rm", "-rf", tmp_path / "d"], check=True)
