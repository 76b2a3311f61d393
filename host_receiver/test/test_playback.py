"""A recording is played to a receiver, which gets its messages."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import bag_scene
from bag_readers import digest, mcap_file, with_mcap
from bag_scene import COMPRESSED_REQUEST, COUNT, REQUEST
from command_line import refusal
from fake_sink import FakeSink
from ml2_receiver.recording.bag_folder import make_folder
from ml2_receiver.recording.recorder import Recorder
from ml2_receiver.session.streams import Request
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.config_topic import ConfigText
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.wire.messages import ChannelStatus
from ml2_tools.playback.answers import Repertoire
from playback_scene import CUSTOM, play, played, receiving, write_custom


def test_it_sends_what_was_recorded(bag: Path) -> None:
    sink = played(bag)
    report = sink.await_report()
    assert {bag_scene.absolute(name): sent for name, sent in sink.payloads.items()} == (
        bag_scene.payloads(COUNT)
    )
    assert report.is_final
    for row in report.topics:
        count = COUNT if row.topic.name in bag_scene.SENT else 0
        assert row.device == ChannelStatus(count, count, {})
        captured_ns = row.statistics.times_ns(0, row.statistics.received)[:, 0]
        assert captured_ns.tolist() == [number * 10**9 + 5 for number in range(count)]


def test_it_is_who_was_recorded(bag: Path) -> None:
    report = played(bag).await_report()
    assert report.headset == "device name"
    assert report.clock is not None
    assert report.clock.state == "frozen"


def test_only_what_is_asked_for_is_sent_and_what_was_not_recorded_is_refused(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sink = played(bag, {"battery": {}, "gaze": {"backend": "openxr"}}, code=1)
    assert sink.payloads.keys() == {"battery"}
    said = capsys.readouterr().err
    assert "gaze is refused: the recording does not have it" in said
    (rest,) = (line for line in said.splitlines() if "does not ask for" in line)
    assert {"world_left/image_raw,", "/tf"} <= {*rest.split()}
    assert "battery" not in rest
    answers = sink.applied[0].streams
    assert answers["battery"].result == "applied"
    assert (answers["gaze"].result, answers["gaze"].reason) == (
        "refused",
        "the recording does not have it",
    )


@pytest.fixture
def custom_bag(tmp_path: Path) -> Path:
    return write_custom(tmp_path / "custom")


def test_custom_topics_are_played(custom_bag: Path) -> None:
    sink = played(custom_bag, {"custom": {}}, "--rate", "100")
    report = sink.await_report()
    sent = [bag_scene.battery(second) for second in (0, 1)]
    assert sink.payloads == {"custom/name": sent, "custom/thing": sent}
    rows = {row.topic.name: row for row in report.topics}
    known, other = (rows[name.removeprefix("/p/")].statistics for name in CUSTOM)
    assert known.times_ns(0, 2)[:, 0].tolist() == [5, 10**9 + 5], "the header's stamp"
    assert other.times_ns(0, 2)[:, 0].tolist() == [0, 10**9], "when it was recorded"


def test_a_topic_that_the_receiver_refuses_costs_no_other(
    custom_bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sink = FakeSink()
    sink.unmakeable = {"my_msgs/msg/Thing"}
    played(custom_bag, {"custom": {}}, "--rate", "100", code=1, sink=sink)
    report = sink.await_report()
    assert len(sink.payloads["custom/name"]) == 2
    assert "custom/thing is refused: there is no my_msgs/msg/Thing" in capsys.readouterr().err
    rows = {row.topic.name: row for row in report.topics}
    assert rows["custom/thing"].device == ChannelStatus(0, 0, {}), "it is not sent in vain"


def test_topics_that_are_left_out_are_neither_sent_nor_missed(bag: Path) -> None:
    topics = ("battery", "/magic_leap2/world_left/image_raw")
    sink = played(bag, REQUEST, "--topics", *topics)
    assert sink.payloads.keys() == {"battery", "world_left/image_raw"}
    assert sink.applied[0].streams["tf"].reason == "--topics leaves it out"


def test_a_topic_that_the_recording_does_not_have_cannot_be_chosen(bag: Path) -> None:
    said = refusal("play", bag, "--topics", "battery", "gaze")
    assert "no topic gaze; it has world_left/image_raw" in said


def test_nothing_sent_is_no_success(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    played(bag, REQUEST, "--start-offset", "3600", code=1)
    assert "played 0 messages" in capsys.readouterr().out


def test_a_stream_that_was_recorded_otherwise_is_adjusted(bag: Path) -> None:
    sink = played(bag, {"world_left": {"stream": 1, "format": "Grayscale"}})
    answer = sink.applied[0].streams["world_left"]
    assert (answer.result, answer.values) == ("adjusted", REQUEST["world_left"])


@pytest.fixture(scope="module")
def compressed_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compressed") / "walk"
    bag_scene.record(folder, COUNT, request=COMPRESSED_REQUEST)
    return folder


def test_compressed_images_are_played_to_a_receiver_that_asks_for_them(
    compressed_bag: Path,
) -> None:
    sink = played(compressed_bag, COMPRESSED_REQUEST)
    assert sink.payloads == {
        name: [make(number) for number in range(COUNT)]
        for name, (_, make) in bag_scene.COMPRESSED.items()
    }
    assert {it.result for it in sink.applied[0].streams.values()} == {"applied"}
    names = {topic.name for topic in sink.applied[0].topics}
    assert not {"world_left/image_raw", "depth/image_raw"} & names


@pytest.mark.parametrize(
    ("recorded", "requested", "reason"),
    [
        ("compressed_bag", {"format": "Grayscale"}, "format jpeg, requested with Grayscale"),
        ("bag", {"format": "jpeg"}, "format Grayscale, requested with jpeg"),
    ],
)
def test_a_camera_in_another_format_is_refused_and_costs_no_other_stream(
    request: pytest.FixtureRequest,
    capsys: pytest.CaptureFixture[str],
    recorded: str,
    requested: dict[str, str],
    reason: str,
) -> None:
    streams: Request = {"battery": {}, "depth": {"format": "depth16"}, "world_left": requested}
    sink = played(request.getfixturevalue(recorded), streams, code=1)
    assert f"world_left is refused: recorded with {reason}" in capsys.readouterr().err
    answer = sink.applied[0].streams["world_left"]
    assert (answer.result, answer.reason) == ("refused", f"recorded with {reason}")
    other = "depth/image_raw/compressedDepth" if recorded == "compressed_bag" else "battery"
    assert {name: len(sent) for name, sent in sink.payloads.items()} == {other: COUNT}


def test_of_a_recording_in_two_formats_the_requested_one_is_played() -> None:
    text: dict[str, Any] = {"result": "applied", "reason": None, "topics": []}
    values = {"format": "Grayscale", "stream": 1}
    config = {"headset": "h", "session": "s", "streams": {"world_left": {**text, "values": values}}}
    types = {
        "/p/world_left/image_raw": "sensor_msgs/msg/Image",
        "/p/world_left/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
    }
    parsed = ConfigText.parse(json.dumps(config).encode())
    reader: Any = SimpleNamespace(prefix="/p", types=types, config=parsed)
    repertoire = Repertoire.of(reader, load_table())
    request: Request = {"world_left": {"format": "jpeg", "stream": 0}}
    (topic,) = repertoire.announced(request)
    assert topic.name == "world_left/image_raw/compressed"
    answer = repertoire.answers(request)["world_left"]
    assert (answer.result, answer.values) == ("adjusted", {"format": "jpeg", "stream": 1})


def test_a_recording_of_a_playback_has_the_same_messages(bag: Path, tmp_path: Path) -> None:
    sink = FakeSink()
    writer = bag_scene.new_writer(tmp_path / "again")
    recorder = Recorder(writer, load_table(), "/again", pytest.fail)
    with receiving(FanOut([sink, recorder])) as server:
        play(bag, server)
        sink.await_report()
    recorder.close()
    for name in ("world_left/image_raw", "battery"):
        assert [
            [seen.sha256 for seen in with_mcap(folder) if seen.topic.endswith(name)]
            for folder in (bag, tmp_path / "again")
        ] == [[digest(bag_scene.SENT[name][1](number)) for number in range(COUNT)]] * 2


def test_what_a_kill_has_left_is_played(bag: Path, tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    make_folder(folder, is_overwriting=False)
    file = mcap_file(folder)
    file.write_bytes(mcap_file(bag).read_bytes()[:-3000])
    sink = played(folder)
    assert sink.payloads["battery"] == bag_scene.payloads(COUNT)["/magic_leap2/battery"]
