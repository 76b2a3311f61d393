"""Tests the times at which messages are played, and files that are no recordings."""

import struct
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

import bag_scene
from bag_readers import mcap_file
from command_line import refusal
from ml2_receiver.errors import RecordingError
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.playback import timeline
from ml2_tools.playback.answers import Repertoire
from ml2_tools.playback.player import Player
from ml2_tools.playback.timeline import Timeline

SECOND_NS = 10**9
type Messages = list[tuple[str, int, bytes]]


class FakeSession:
    """Wants `topics`, and does `then` with each capture time in seconds."""

    def __init__(self, then: Callable[[int], None] = lambda _: None, topics: str = "battery"):
        self.epoch = 0
        self.sent: list[int] = []
        self._then, self._topics = then, topics

    def is_wanted(self, topic: Topic) -> bool:
        return topic.name in self._topics

    def send(self, topic: Topic, payload: bytes, capture_ns: int) -> None:
        self.sent.append(capture_ns // SECOND_NS)
        self._then(self.sent[-1])


class Scene:
    """Time that passes only when it is waited for."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 0.0
        monkeypatch.setattr(timeline, "monotonic", lambda: self.now_s)
        self.stopping = Waits(self)

    def pass_time(self, seconds: float) -> None:
        self.now_s += seconds


class Waits(threading.Event):
    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self._scene = scene

    def wait(self, timeout: float | None = None) -> bool:
        self._scene.pass_time(timeout or 0)
        return self.is_set()


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    return Scene(monkeypatch)


def a_timeline(start_s: float = 0, rate: float = 1, *, is_paused: bool = False) -> Timeline:
    return Timeline(0, round(start_s * SECOND_NS), rate, is_paused=is_paused)


def a_player(folder: Path, messages: Messages, session: FakeSession, time: Timeline) -> Player:
    types = {"/tf_static": "tf2_msgs/msg/TFMessage"}
    reader = BagReader(bag_scene.written(folder / "walk", messages, types))
    repertoire = Repertoire.of(reader, load_table())
    return Player(reader, repertoire, session, time)  # type: ignore[arg-type]


def batteries(*seconds: int) -> Messages:
    return [("/p/battery", second, bag_scene.battery(second)) for second in seconds]


def test_the_rate_divides_the_time_between_messages(tmp_path: Path, scene: Scene) -> None:
    sent_s: list[float] = []
    session = FakeSession(lambda _: sent_s.append(scene.now_s))
    player = a_player(tmp_path, batteries(0, 1000, 2000), session, a_timeline(rate=4))
    player.play(scene.stopping)
    assert sent_s == pytest.approx([0, 250, 500], abs=0.1)
    assert session.sent == [0, 1000, 2000]


def test_it_begins_where_it_is_told_to_with_the_mountings_of_before(
    tmp_path: Path, scene: Scene
) -> None:
    """A subscriber to /tf_static gets the last message, however late it comes."""
    static = [("/tf_static", second, bag_scene.tf(second)) for second in (1, 2)]
    session = FakeSession(topics="battery /tf_static")
    messages = sorted([*batteries(0, 10, 20, 30), *static], key=lambda it: it[1])
    a_player(tmp_path, messages, session, a_timeline(15)).play(scene.stopping)
    assert session.sent == [2, 20, 30]
    assert scene.now_s == pytest.approx(15, abs=0.1)


def test_a_pause_lasts_until_it_is_ended(tmp_path: Path, scene: Scene) -> None:
    time = a_timeline()
    sent_s: list[float] = []

    def pause_at_one(second: int) -> None:
        sent_s.append(scene.now_s)
        if second == 1:
            time.toggle()

    def go_on_at_a_hundred(seconds: float) -> None:
        scene.now_s += seconds
        if scene.now_s > 100 and time.is_paused:
            time.toggle()

    scene.pass_time = go_on_at_a_hundred  # type: ignore[method-assign]
    session = FakeSession(pause_at_one)
    a_player(tmp_path, batteries(0, 1, 2, 3), session, time).play(scene.stopping)
    assert sent_s == pytest.approx([0, 1, 101, 102], abs=0.2)


def test_it_goes_back_and_forward_when_told_to(tmp_path: Path, scene: Scene) -> None:
    time = a_timeline()
    jumps_s = deque([(20, -15.0), (10, 25.0)])

    def jump(second: int) -> None:
        if jumps_s and jumps_s[0][0] == second:
            time.jump_by(jumps_s.popleft()[1])

    session = FakeSession(jump)
    a_player(tmp_path, batteries(0, 10, 20, 30, 40), session, time).play(scene.stopping)
    assert session.sent == [0, 10, 20, 10, 40]
    assert session.epoch == 2


def test_it_stops_when_told_to(tmp_path: Path, scene: Scene) -> None:
    session = FakeSession(lambda second: scene.stopping.set() if second else None)
    a_player(tmp_path, batteries(0, 1, 2), session, a_timeline()).play(scene.stopping)
    assert session.sent == [0, 1]


@pytest.mark.parametrize(
    ("payload", "words"),
    [
        (bytes([0, 1, 0, 0]) + bytes(64 * 1024), "expected at most 65536"),
        (bytes([0, 0, 0, 0, 1]), "has /p/battery in big-endian CDR"),
        (bytes([0, 9, 0, 0, 1]), "has /p/battery in XCDR2"),
        (bytes([9, 1, 0, 0, 1]), "is not little-endian CDR"),
    ],
)
def test_a_message_that_no_receiver_takes_ends_the_playback(
    tmp_path: Path, scene: Scene, payload: bytes, words: str
) -> None:
    messages = [("/p/battery", 1, payload)]
    with pytest.raises(RecordingError, match=words):
        a_player(tmp_path, messages, FakeSession(), a_timeline()).play(scene.stopping)


def test_what_is_no_recording_is_refused_with_the_reason(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.mcap"
    writer = Writer(str(foreign))
    writer.start()
    writer.finish()
    text = tmp_path / "text.mcap"
    text.write_text("no recording at all")
    (tmp_path / "empty").mkdir()
    cases = {
        tmp_path / "empty": "expected .mcap files in",
        foreign: "foreign.mcap has no topics",
        text: "is broken: not a valid MCAP file",
        tmp_path / "missing": "No such file or directory",
    }
    for path, reason in cases.items():
        assert reason in refusal("play", path)


def test_a_length_that_no_machine_can_have_is_refused_with_the_reason(tmp_path: Path) -> None:
    unknown = struct.pack("<BQ", 0x70, 1 << 63)
    chunk = struct.pack("<QQQIIQ", 0, 0, len(unknown), 0, 0, len(unknown)) + unknown
    header = struct.pack("<BQ", 1, 8) + bytes(8)
    file = tmp_path / "long.mcap"
    file.write_bytes(
        b"\x89MCAP0\r\n" + header + struct.pack("<BQ", 6, len(chunk)) + chunk + bytes(9)
    )
    with pytest.raises(RecordingError, match="is broken"):
        BagReader(file)


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


def test_a_timeline_changes_its_speed_pauses_and_goes_on_from_elsewhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = Scene(monkeypatch)
    line = Timeline(0, 0, 1, is_paused=False)
    line.start(0)
    scene.pass_time(2)
    line.set_rate(4)
    line.start(0)
    scene.pass_time(1)
    assert (line.now_ns(), line.rate) == (6 * SECOND_NS, 4)
    line.pause()
    line.start(0)
    scene.pass_time(5)
    assert (line.now_ns(), line.is_paused) == (6 * SECOND_NS, True)
    line.pause(False)
    line.hold(3 * SECOND_NS)
    line.start(0)
    scene.pass_time(1)
    assert (line.now_ns(), line.position) == (7 * SECOND_NS, (0, 0))


def test_messages_that_the_recorder_wrote_late_are_played_in_their_turn(
    tmp_path: Path, scene: Scene
) -> None:
    """Also those that are earlier than the first one in the file."""
    session = FakeSession()
    a_player(tmp_path, batteries(20, 5, 40, 10), session, a_timeline()).play(scene.stopping)
    assert session.sent == [5, 10, 20, 40]


def test_the_time_ends_with_the_last_message(tmp_path: Path, scene: Scene) -> None:
    time = a_timeline(rate=100)
    a_player(tmp_path, batteries(0, 10), FakeSession(), time).play(scene.stopping)
    scene.pass_time(7)
    assert time.offset_s == 10


def test_what_is_not_sent_is_counted_by_topic(tmp_path: Path, scene: Scene) -> None:
    foreign = [("/slam/odom", second, bag_scene.battery(second)) for second in (1, 2, 3)]
    player = a_player(tmp_path, [*batteries(0, 1), *foreign], FakeSession(), a_timeline())
    player.play(scene.stopping)
    assert (player.sent, player.unsent) == (2, {"/slam/odom": 3, "/p/config": 1})
