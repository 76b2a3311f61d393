"""Recordings played to receivers, and files that are none."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import bag_scene
from bag_readers import digest, mcap_file, with_mcap
from bag_scene import COMPRESSED_REQUEST, COUNT, REQUEST
from fake_sink import FakeSink
from ml2_receiver.cli import main
from ml2_receiver.recording.bag_folder import make_folder
from ml2_receiver.recording.bag_writer import BagWriter
from ml2_receiver.recording.recorder import Recorder
from ml2_receiver.session.report import State
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import ReceiverSettings
from ml2_receiver.session.sink import Sink
from ml2_receiver.session.streams import Request
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.config_topic import ConfigText
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.transport.access import Access, Everybody, PairedOnly
from ml2_receiver.transport.listener import listen
from ml2_receiver.wire.messages import ChannelStatus
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.playback.answers import Repertoire
from ml2_tools.playback.lane import Destination
from ml2_tools.playback.session import Session
from ros_processes import Child, environment
from waiting import LIMIT_S


@contextmanager
def receiving(
    sink: Sink, request: Request = bag_scene.REQUEST, access: Access | None = None
) -> Iterator[Server]:
    listener = listen(("127.0.0.1", 0))
    server = Server(
        listener,
        access or Everybody(),
        sink,
        request,
        ReceiverSettings("test", "test"),
    )
    try:
        yield server
    finally:
        server.stop()


def play(bag: Path, server: Server, *options: str) -> int:
    return main(["play", str(bag), "--receiver", server.address, "--insecure", *options])


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


def test_only_what_is_asked_for_is_sent_and_what_was_not_recorded_is_refused(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sink = FakeSink()
    with receiving(sink, {"battery": {}, "gaze": {"backend": "openxr"}}) as server:
        assert play(bag, server) == 1
        sink.await_report()
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


CUSTOM = ("/p/custom/name", "/p/custom/thing")


@pytest.fixture
def custom_bag(tmp_path: Path) -> Path:
    """One topic of a type that is known, and one of another."""
    messages = [(name, second, bag_scene.battery(second)) for second in (0, 1) for name in CUSTOM]
    types = {CUSTOM[1]: "my_msgs/msg/Thing"}
    return bag_scene.written(tmp_path / "custom", messages, types)


def test_custom_topics_are_played(custom_bag: Path) -> None:
    sink = FakeSink()
    with receiving(sink, {"custom": {}}) as server:
        assert play(custom_bag, server, "--rate", "100") == 0
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
    with receiving(sink, {"custom": {}}) as server:
        assert play(custom_bag, server, "--rate", "100") == 1
        report = sink.await_report()
    assert len(sink.payloads["custom/name"]) == 2
    assert "custom/thing is refused: there is no my_msgs/msg/Thing" in capsys.readouterr().err
    rows = {row.topic.name: row for row in report.topics}
    assert rows["custom/thing"].device == ChannelStatus(0, 0, {}), "it is not sent in vain"


def test_topics_that_are_left_out_are_neither_sent_nor_missed(bag: Path) -> None:
    sink = FakeSink()
    with receiving(sink) as server:
        assert play(bag, server, "--topics", "battery", "/magic_leap2/world_left/image_raw") == 0
        sink.await_report()
    assert sink.payloads.keys() == {"battery", "world_left/image_raw"}
    assert sink.applied[0].streams["tf"].reason == "--topics leaves it out"


def test_a_topic_that_the_recording_does_not_have_cannot_be_chosen(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["play", str(bag), "--topics", "battery", "gaze"]) == 2
    said = capsys.readouterr().err
    assert "no topic gaze; it has world_left/image_raw" in said


def test_nothing_sent_is_no_success(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with receiving(FakeSink()) as server:
        assert play(bag, server, "--start-offset", "3600") == 1
    assert "played 0 messages" in capsys.readouterr().out


def test_a_stream_that_was_recorded_otherwise_is_adjusted(bag: Path) -> None:
    sink = FakeSink()
    with receiving(sink, {"world_left": {"stream": 1, "format": "Grayscale"}}) as server:
        play(bag, server)
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
    sink = FakeSink()
    with receiving(sink, COMPRESSED_REQUEST) as server:
        assert play(compressed_bag, server) == 0
        sink.await_report()
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
    sink, walk = FakeSink(), request.getfixturevalue(recorded)
    streams: Request = {"battery": {}, "depth": {"format": "depth16"}, "world_left": requested}
    with receiving(sink, streams) as server:
        assert play(walk, server) == 1
        sink.await_report()
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
            *("-m", "ml2_receiver", "play", str(bag), "--receiver", server.address),
            *("--insecure", "--loop"),
        ) as child,
    ):
        sink.await_payloads("battery", 3 * COUNT)
        assert child.end() == 0
        assert child.line() == "playing until Ctrl-C"
        report = sink.await_report()
    assert report.clock is not None
    assert (report.clock.epoch or 0) >= 2
    sent = bag_scene.payloads(COUNT)["/magic_leap2/battery"]
    assert sink.payloads["battery"][: 3 * COUNT] == 3 * sent


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
    assert "the receiver ended the session: " in capsys.readouterr().err


def test_a_receiver_that_is_busy_is_an_error(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with receiving(FakeSink()) as server:
        repertoire = Repertoire.of(BagReader(bag), load_table())
        first = Session(
            Destination(address(server), None),
            "another",
            repertoire,
            pytest.fail,
            threading.Event(),
        )
        table = bag.parent / "other"
        other = table if table.exists() else bag_scene.written(table, [])
        assert play(other, server) == 2
        first.finish()
    assert "the receiver refuses: busy" in capsys.readouterr().err


def test_it_plays_over_tls_to_a_receiver_with_the_same_keys(bag: Path, tmp_path: Path) -> None:
    sink = FakeSink()
    keys = ["--keys", str(tmp_path)]
    with receiving(sink, access=PairedOnly(tmp_path)) as server:
        assert main(["play", str(bag), "--receiver", server.address, *keys]) == 0
        report = sink.await_report()
    assert (report.state, report.is_final) == (State.ENDED, True)
    assert {bag_scene.absolute(name): sent for name, sent in sink.payloads.items()} == (
        bag_scene.payloads(COUNT)
    )


def test_it_plays_to_no_receiver_with_other_keys(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    keys = ["--keys", str(tmp_path / "mine")]
    with receiving(FakeSink(), access=PairedOnly(tmp_path / "theirs")) as server:
        assert main(["play", str(bag), "--receiver", server.address, *keys]) == 2
        assert f"the receiver at {server.address} has other keys" in capsys.readouterr().err


def test_one_side_alone_without_tls_is_told_so(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with receiving(FakeSink()) as server:
        keys = ["--keys", str(tmp_path)]
        assert main(["play", str(bag), "--receiver", server.address, *keys]) == 2
    assert "If the receiver runs with --insecure" in capsys.readouterr().err
    with receiving(FakeSink(), access=PairedOnly(tmp_path)) as server:
        assert play(bag, server) == 2
    assert "the receiver refuses: pairing: this port speaks TLS only" in capsys.readouterr().err


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
    assert "Start `ml2-receiver run`" in said


@pytest.mark.parametrize("rate", ["0", "-1", "nan", "inf", "x"])
def test_a_rate_is_above_zero(rate: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["play", "walk", "--rate", rate])
    assert f"expected a number above 0, found {rate!r}" in capsys.readouterr().err


COLOURS = re.compile(rb"\x1b\[[0-9;?]*[A-Za-z]")


@contextmanager
def on_a_terminal(*arguments: str) -> Iterator[tuple[int, subprocess.Popen[bytes]]]:
    """A command with a terminal of its own, and the other end of that."""
    terminal, inner = pty.openpty()
    process = subprocess.Popen(
        ["setsid", "--ctty", sys.executable, "-m", "ml2_receiver", *arguments],
        stdin=inner,
        stdout=inner,
        stderr=inner,
        env={**environment(), "TERM": "xterm"},
    )
    os.close(inner)
    try:
        yield terminal, process
    finally:
        process.kill()
        process.wait()
        os.close(terminal)


def test_the_space_bar_ends_a_pause(bag: Path) -> None:
    sink = FakeSink()
    with receiving(sink) as server:
        options = ("--receiver", server.address, "--insecure", "--start-paused")
        with on_a_terminal("play", str(bag), *options) as (terminal, process):
            shown = b""
            while b"paused" not in shown:
                shown += os.read(terminal, 1024)
            assert not sink.payloads["battery"]
            os.write(terminal, b" ")
            sink.await_payloads("battery", COUNT)
            with suppress(OSError):  # the terminal ends with the process
                while os.read(terminal, 1024):
                    pass
            assert process.wait(LIMIT_S) == 0


def test_the_arrows_go_forward_and_back(tmp_path: Path) -> None:
    messages = [("/p/battery", 10 * n, bag_scene.battery(10 * n)) for n in range(4)]
    walk = bag_scene.written(tmp_path / "walk", messages)
    sink = FakeSink()
    with receiving(sink, {"battery": {}}) as server:
        options = ("--receiver", server.address, "--insecure", "--start-paused")
        with on_a_terminal("play", str(walk), *options) as (terminal, process):
            for pressed, shown in ((b"", "0.0"), (b"\x1b[C", "5.0"), (b"\x1b[D", "0.0")):
                os.write(terminal, pressed)
                await_shown(terminal, f"to {shown} s, paused")
            os.write(terminal, b"\x1b[C")
            await_shown(terminal, "to 5.0 s, paused")
            os.write(terminal, b" ")
            sink.await_payloads("battery", 1)
            process.send_signal(signal.SIGINT)
            assert process.wait(LIMIT_S) == 0
    assert sink.payloads["battery"] == [bag_scene.battery(10)]


def await_shown(terminal: int, text: str) -> None:
    """Waits until a line drawn from now on has this text."""
    shown = b""
    while text.encode() not in COLOURS.sub(b"", shown):
        shown += os.read(terminal, 1024)


def test_a_pause_that_nothing_can_end_is_refused(
    bag: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with Path(os.devnull).open() as nobody:
        monkeypatch.setattr(sys, "stdin", nobody)
        assert main(["play", str(bag), "--start-paused"]) == 2
    assert "--start-paused needs a terminal" in capsys.readouterr().err


CLOCK = """
import sys
import rclpy
from rclpy.parameter import Parameter
rclpy.init()
node = rclpy.create_node("robot", parameter_overrides=[Parameter("use_sim_time", value=True)])
while node.get_clock().now().nanoseconds == 0:
    rclpy.spin_once(node, timeout_sec=0.1)
print(node.get_clock().now().nanoseconds, flush=True)
"""


def test_nodes_with_use_sim_time_get_the_time_of_the_recording(custom_bag: Path) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    sink = FakeSink()
    with receiving(sink, {"custom": {}}) as server:
        options = ("--insecure", "--loop", "--clock")
        address = ("--receiver", server.address)
        with (
            Child("-m", "ml2_receiver", "play", str(custom_bag), *address, *options) as player,
            Child("-c", CLOCK) as node,
        ):
            assert 0 < int(node.line()) < 2 * 10**9
            assert player.end() == 0
