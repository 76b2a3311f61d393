"""Recordings, receivers and options with names and times that nothing honest has."""

import json
from pathlib import Path

import pytest

import bag_scene
from command_line import refusal
from fake_sink import FakeSink
from ml2_receiver.errors import ProtocolError, PublishError
from ml2_receiver.session.sink import Publish
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.messages import Welcome
from ml2_tools.errors import PlaybackError
from ml2_tools.playback.timeline import Timeline
from playback_scene import CUSTOM, play, receiving, to

LATE_S = 9_300_000_000  # 2^63 ns are 9.22e9 s


@pytest.mark.parametrize("name", ["", "Lab\n2", "\x1b]52;c;aGk=\x07", "\u202eLab", "x" * 65])
def test_the_name_of_a_headset_that_no_receiver_accepts_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    config = json.dumps({"headset": name, "session": "s", "streams": {}})
    monkeypatch.setattr(bag_scene, "CONFIG", config)
    bag = bag_scene.written(tmp_path / "bag", [("/p/battery", 1, bag_scene.battery(1))])
    with receiving(FakeSink()) as server:
        said = refusal("play", bag, *to(server))
    assert "expected 1 to 64 printable characters, found" in said
    assert "Traceback" not in said
    assert "\x1b" not in said
    assert len(said) < 500


def test_a_time_that_the_wire_does_not_have_is_said(tmp_path: Path) -> None:
    thing = CUSTOM[1]
    bag = bag_scene.written(
        tmp_path / "bag", [(thing, LATE_S, bag_scene.battery(1))], {thing: "my_msgs/msg/Thing"}
    )
    with receiving(FakeSink(), {"custom": {}}) as server:
        said = refusal("play", bag, *to(server), "--start-offset", str(LATE_S))
    assert f"has a message at {LATE_S}000000000 ns, the last time of ROS is" in said


def test_the_words_of_a_receiver_move_no_cursor(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    class HostileError(PublishError):
        def __str__(self) -> str:  # which else is cleaned by the receiver
            return "no \x1b]52;c;aGk=\x07"

    class Refusing(FakeSink):
        def open(self, topic: Topic) -> Publish:
            if topic.name == "battery":
                raise HostileError("no")
            return super().open(topic)

    with receiving(Refusing()) as server:
        assert play(bag, server) == 1
    said = capsys.readouterr().err
    assert "battery is refused: no " in said
    assert "\x1b" not in said


@pytest.mark.parametrize("at_ns", [1 << 61, (1 << 64) - 1])
def test_a_time_that_ros_does_not_have_is_said(at_ns: int) -> None:
    clock = pytest.importorskip("ml2_tools.playback.ros_clock", reason="needs rclpy")
    with pytest.raises(PlaybackError, match="ROS has times up to 2147483647999999999 ns"):
        clock.RosClock(Timeline(at_ns, at_ns, 1.0, is_paused=True))


@pytest.mark.parametrize(
    "option",
    [
        ("--start-offset", "1e300"),
        ("--start-offset", "-1"),
        ("--start-offset", "nan"),
        ("--rate", "1e308"),
        ("--rate", "inf"),
    ],
)
def test_an_option_beyond_all_recordings_is_refused(option: tuple[str, str], bag: Path) -> None:
    assert f"argument {option[0]}: expected " in refusal("play", bag, *option)


def welcome(**timeouts: float) -> bytes:
    document = {
        "version": 1,
        "session": "s",
        "name": "n",
        "software": "s",
        "tickets": {},
        "received": None,
        "limits": {"data_bytes": 1},
        "timeouts": {"handshake_s": 5.0, "ping_s": 0.5, "dead_s": 3.0, **timeouts},
    }
    return json.dumps(document).encode()


@pytest.mark.parametrize("key", ["handshake_s", "ping_s", "dead_s"])
@pytest.mark.parametrize("value", [0, -1, -1e308, 1 << 63, -(1 << 63)])
def test_timeouts_are_finite_and_above_0(key: str, value: float) -> None:
    assert Welcome.parse(welcome(**{key: 1e308})).timeouts
    with pytest.raises(ProtocolError, match=r"malformed: .*(above 0|finite)"):
        Welcome.parse(welcome(**{key: value}))
