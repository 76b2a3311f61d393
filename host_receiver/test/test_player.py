"""When messages are played, and files that are no recordings."""

import struct
import threading
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

import bag_scene
from bag_readers import mcap_file
from ml2_receiver.cli import main
from ml2_receiver.configuration.table import Topic, load_table
from ml2_receiver.errors import RecordingError
from ml2_receiver.playback.player import Player
from ml2_receiver.recording.bag_reader import BagReader


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


def test_the_rate_divides_the_time_between_messages(tmp_path: Path) -> None:
    messages = [("/p/battery", 1000 * number, bag_scene.battery(number)) for number in range(3)]
    reader = BagReader(bag_scene.written(tmp_path / "walk", messages))
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
    reader = BagReader(bag_scene.written(tmp_path / "walk", [("/p/battery", 1, payload)]))
    player = Player(reader, load_table(), FakeSession(), 1.0)  # type: ignore[arg-type]
    with pytest.raises(RecordingError, match=words):
        player.play(Waits())


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
