"""Recordings played to receivers, and files that are none."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

import bag_scene
from bag_readers import digest, mcap_file, with_mcap
from fake_sink import FakeSink
from ml2_receiver.cli import main
from ml2_receiver.errors import RecordingError
from ml2_receiver.fan_out import FanOut
from ml2_receiver.messages import ChannelStatus
from ml2_receiver.playback.player import Player
from ml2_receiver.playback.session import Session
from ml2_receiver.recording.bag_folder import make_folder
from ml2_receiver.recording.bag_reader import BagReader
from ml2_receiver.recording.bag_topic import BagTopic
from ml2_receiver.recording.bag_writer import BagWriter
from ml2_receiver.recording.recorder import Recorder
from ml2_receiver.server import Server, listen
from ml2_receiver.sink import Sink
from ml2_receiver.streams import Request
from ml2_receiver.string_message import encode_string
from ml2_receiver.table import Topic, load_table
from ros_processes import Child

COUNT = 30
CONFIG = '{"headset": "h", "session": "s", "streams": {}}'


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags") / "walk"
    bag_scene.record(folder, COUNT, "zstd")
    return folder


@contextmanager
def receiving(sink: Sink, request: Request = bag_scene.REQUEST) -> Iterator[Server]:
    listener = listen(("127.0.0.1", 0))
    server = Server(listener, load_table(), request, sink, name="test", software="test")
    try:
        yield server
    finally:
        server.stop()


def play(bag: Path, server: Server, *options: str) -> int:
    return main(["play", str(bag), "--receiver", server.address, *options])


def test_it_sends_what_was_recorded(bag: Path) -> None:
    sink = FakeSink()
    with receiving(sink) as server:
        assert play(bag, server) == 0
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
    sink = FakeSink()
    with receiving(sink) as server:
        play(bag, server)
        report = sink.await_report()
    assert report.headset == "device name"
    assert report.clock is not None
    assert report.clock.state == "frozen"


def test_only_what_is_asked_for_is_sent_and_what_was_not_recorded_is_refused(bag: Path) -> None:
    sink = FakeSink()
    with receiving(sink, {"battery": {}, "gaze": {"backend": "openxr"}}) as server:
        assert play(bag, server) == 0
        sink.await_report()
    assert sink.payloads.keys() == {"battery"}
    answers = sink.applied[0].streams
    assert answers["battery"].result == "applied"
    assert (answers["gaze"].result, answers["gaze"].reason) == (
        "refused",
        "the recording does not have it",
    )


def test_a_stream_that_was_recorded_otherwise_is_adjusted(bag: Path) -> None:
    sink = FakeSink()
    with receiving(sink, {"world_left": {"stream": 1}}) as server:
        play(bag, server)
    answer = sink.applied[0].streams["world_left"]
    assert (answer.result, answer.values) == ("adjusted", {"stream": 0})


def test_a_recording_of_a_playback_has_the_same_messages(bag: Path, tmp_path: Path) -> None:
    sink = FakeSink()
    make_folder(tmp_path / "again", is_overwriting=False)
    writer = BagWriter(tmp_path / "again", "none")
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
    sink = FakeSink()
    with receiving(sink) as server:
        assert play(folder, server) == 0
        sink.await_report()
    assert sink.payloads["battery"] == bag_scene.payloads(COUNT)["/magic_leap2/battery"]


def test_it_plays_again_and_again_until_interrupted(bag: Path) -> None:
    sink = FakeSink()
    with (
        receiving(sink) as server,
        Child(
            "-m", "ml2_receiver", "play", str(bag), "--receiver", server.address, "--loop"
        ) as child,
    ):
        sink.await_payloads("battery", 3 * COUNT)
        assert child.end() == 0
        assert child.line() == "playing until Ctrl-C"
        assert sink.await_report().is_final
    sent = bag_scene.payloads(COUNT)["/magic_leap2/battery"]
    assert sink.payloads["battery"][: 3 * COUNT] == 3 * sent


class FakeSession:
    def __init__(self) -> None:
        self.sent: list[int] = []

    def is_wanted(self, topic: Topic) -> bool:
        return topic.name == "battery"

    def send(self, topic: Topic, payload: bytes, capture_ns: int) -> None:
        self.sent.append(capture_ns)


class Waits(threading.Event):
    """Time that passes without being waited for."""

    def __init__(self) -> None:
        super().__init__()
        self.waits_s: list[float] = []

    def wait(self, timeout: float | None = None) -> bool:
        self.waits_s.append(timeout or 0)
        return False


def written(folder: Path, messages: list[tuple[str, int, bytes]]) -> Path:
    """A recording of these topics, times in s and payloads, after the configuration."""
    make_folder(folder, is_overwriting=False)
    writer = BagWriter(folder, "none")
    table = load_table()
    topics = {"/p/config": BagTopic("/p/config", "std_msgs/msg/String", table.qos["latched"])}
    for name, _, _ in messages:
        topics[name] = BagTopic(name, "sensor_msgs/msg/BatteryState", table.qos["sensor"])
    for topic in topics.values():
        writer.add_topic(topic)
    writer.write(topics["/p/config"], 0, encode_string(CONFIG))
    for name, time_s, payload in messages:
        writer.write(topics[name], time_s * 10**9, payload)
    writer.close()
    return folder


def test_the_rate_divides_the_time_between_messages(tmp_path: Path) -> None:
    messages = [("/p/battery", 1000 * number, bag_scene.battery(number)) for number in range(3)]
    reader = BagReader(written(tmp_path / "walk", messages))
    session, waits = FakeSession(), Waits()
    Player(reader, load_table(), session, rate=4.0).play(waits)  # type: ignore[arg-type]
    assert waits.waits_s == pytest.approx([0, 0, 250, 500], abs=50)
    assert session.sent == [5, 10**9 + 5, 2 * 10**9 + 5]


@pytest.mark.parametrize(
    ("payload", "words"),
    [
        (bytes([0, 1, 0, 0]) + bytes(64 * 1024), "expected at most 65536"),
        (bytes([0, 0, 0, 0, 1]), "is not little-endian CDR"),
    ],
)
def test_a_message_that_no_receiver_takes_ends_the_playback(
    tmp_path: Path, payload: bytes, words: str
) -> None:
    reader = BagReader(written(tmp_path / "walk", [("/p/battery", 1, payload)]))
    player = Player(reader, load_table(), FakeSession(), 1.0)  # type: ignore[arg-type]
    with pytest.raises(RecordingError, match=words):
        player.play(Waits())


def test_a_receiver_that_ends_the_session_ends_the_playback(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sink = FakeSink()
    with receiving(sink) as server:

        def stop_in_the_middle() -> None:
            sink.await_payloads("battery", 2 * COUNT)
            server.stop()

        stopper = threading.Thread(target=stop_in_the_middle)
        stopper.start()
        assert play(bag, server, "--loop") == 2
        stopper.join()
    assert "the receiver says goodbye" in capsys.readouterr().err


def test_a_receiver_that_is_busy_is_an_error(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with receiving(FakeSink()) as server:
        first = Session(address(server), BagReader(bag), load_table(), threading.Event())
        table = bag.parent / "other"
        other = table if table.exists() else written(table, [])
        assert play(other, server) == 2
        first.finish()
    assert "the receiver refuses: busy" in capsys.readouterr().err


def address(server: Server) -> tuple[str, int]:
    host, _, port = server.address.rpartition(":")
    return host, int(port)


def test_without_a_receiver_it_says_what_to_start(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with listen(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    assert main(["play", str(bag), "--receiver", f"127.0.0.1:{port}"]) == 2
    said = capsys.readouterr().err
    assert f"no receiver at 127.0.0.1:{port}" in said
    assert "start `ml2-receiver run`" in said


@pytest.mark.parametrize("rate", ["0", "-1", "nan", "inf", "x"])
def test_a_rate_is_above_zero(rate: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["play", "walk", "--rate", rate])
    assert f"expected a rate above 0, found {rate!r}" in capsys.readouterr().err


def test_what_is_no_recording_is_refused_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    foreign = tmp_path / "foreign.mcap"
    writer = Writer(str(foreign))
    writer.start()
    writer.finish()
    text = tmp_path / "text.mcap"
    text.write_text("no recording at all")
    cases = {
        foreign: "is not of ml2-receiver: it has no topic .../config",
        text: "is broken: not a valid MCAP file",
        tmp_path / "missing": "No such file or directory",
    }
    for path, reason in cases.items():
        assert main(["play", str(path)]) == 2
        assert reason in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert main(["play", str(tmp_path / "empty")]) == 2
    assert "expected one .mcap file" in capsys.readouterr().err


@settings(max_examples=200)
@given(data=st.data())
def test_a_broken_file_is_a_recording_error_and_nothing_else(
    bag: Path, data: st.DataObject
) -> None:
    whole = mcap_file(bag).read_bytes()
    broken = bytearray(whole[: data.draw(st.integers(0, len(whole)))])
    for _ in range(data.draw(st.integers(0, 4))):
        if broken:
            broken[data.draw(st.integers(0, len(broken) - 1))] = data.draw(st.integers(0, 255))
    file = bag.parent / "broken.mcap"
    file.write_bytes(broken)
    try:
        for _ in BagReader(file).messages():
            pass
    except RecordingError:
        pass
