"""`ml2-receiver play` as a command: its ends, its keys, and receivers that refuse it."""

import os
import re
import signal
import sys
import threading
from pathlib import Path

import pytest

import bag_scene
from bag_scene import COUNT
from command_line import refusal
from fake_sink import FakeSink
from free_port import reserve_port
from ml2_receiver.cli import main
from ml2_receiver.session.report import State
from ml2_receiver.table.reader import load_table
from ml2_receiver.transport.access import PairedOnly
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.playback.answers import Repertoire
from ml2_tools.playback.lane import Destination
from ml2_tools.playback.session import PlaybackSession
from playback_scene import receiving, to, write_custom
from ros_processes import Child
from terminal import OnTerminal
from waiting import LIMIT_S


def test_it_plays_again_and_again_until_interrupted(bag: Path) -> None:
    sink = FakeSink()
    with (
        receiving(sink) as server,
        Child("-m", "ml2_receiver", "play", str(bag), *to(server), "--loop") as child,
    ):
        sink.await_payloads("battery", 3 * COUNT)
        assert child.end() == 0
        assert child.line() == "playing until Ctrl-C"
        report = sink.await_report()
    assert report.clock is not None
    assert (report.clock.epoch or 0) >= 2
    sent = bag_scene.payloads(COUNT)["/magic_leap2/battery"]
    assert sink.payloads["battery"][: 3 * COUNT] == 3 * sent


def test_a_receiver_that_ends_the_session_ends_the_playback(bag: Path) -> None:
    sink = FakeSink()
    with receiving(sink) as server:

        def stop_in_the_middle() -> None:
            sink.await_payloads("battery", 2 * COUNT)
            server.stop()

        stopper = threading.Thread(target=stop_in_the_middle)
        stopper.start()
        said = refusal("play", bag, *to(server), "--loop")
        stopper.join()
    assert "the receiver ended the session: " in said


def test_a_receiver_that_is_busy_is_an_error(bag: Path, tmp_path: Path) -> None:
    with receiving(FakeSink()) as server:
        repertoire = Repertoire.of(BagReader(bag), load_table())
        host, _, port = server.address.rpartition(":")
        destination = Destination((host, int(port)), None)
        first = PlaybackSession(destination, "another", repertoire, pytest.fail, threading.Event())
        other = bag_scene.written(tmp_path / "other", [])
        assert "the receiver refuses: busy" in refusal("play", other, *to(server))
        first.finish()


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


def test_it_plays_to_no_receiver_with_other_keys(bag: Path, tmp_path: Path) -> None:
    keys = ("--keys", tmp_path / "mine")
    with receiving(FakeSink(), access=PairedOnly(tmp_path / "theirs")) as server:
        said = refusal("play", bag, "--receiver", server.address, *keys)
        assert f"the receiver at {server.address} has other keys" in said


def test_one_side_alone_without_tls_is_told_so(bag: Path, tmp_path: Path) -> None:
    with receiving(FakeSink()) as server:
        said = refusal("play", bag, "--receiver", server.address, "--keys", tmp_path)
    assert "If the receiver runs with --insecure" in said
    with receiving(FakeSink(), access=PairedOnly(tmp_path)) as server:
        said = refusal("play", bag, *to(server))
    assert "the receiver refuses: pairing: this port speaks TLS only" in said


def test_without_a_receiver_it_says_what_to_start(bag: Path) -> None:
    port = reserve_port()
    said = refusal("play", bag, "--receiver", f"127.0.0.1:{port}")
    assert f"no receiver at 127.0.0.1:{port}" in said
    assert "Start `ml2-receiver run`" in said


@pytest.mark.parametrize("rate", ["0", "-1", "nan", "inf", "x"])
def test_a_rate_is_above_zero(rate: str) -> None:
    assert f"expected a number above 0, found {rate!r}" in refusal("play", "walk", "--rate", rate)


def test_the_space_bar_ends_a_pause(bag: Path) -> None:
    sink = FakeSink()
    with (
        receiving(sink) as server,
        OnTerminal("play", str(bag), *to(server), "--start-paused") as player,
    ):
        player.await_shown(b"paused")
        assert not sink.payloads["battery"]
        player.press(b" ")
        sink.await_payloads("battery", COUNT)
        player.read_to_the_end()
        assert player.process.wait(LIMIT_S) == 0


def test_the_arrows_go_forward_and_back(tmp_path: Path) -> None:
    messages = [("/p/battery", 10 * n, bag_scene.battery(10 * n)) for n in range(4)]
    walk = bag_scene.written(tmp_path / "walk", messages)
    sink = FakeSink()
    with (
        receiving(sink, {"battery": {}}) as server,
        OnTerminal("play", str(walk), *to(server), "--start-paused") as player,
    ):
        keys = ((b"", b"0.0"), (b"\x1b[C", b"5.0"), (b"\x1b[D", b"0.0"), (b"\x1b[C", b"5.0"))
        for pressed, shown in keys:
            player.press(pressed)
            player.await_shown(b"to %s s, paused" % re.escape(shown))
        player.press(b" ")
        sink.await_payloads("battery", 1)
        player.process.send_signal(signal.SIGINT)
        assert player.process.wait(LIMIT_S) == 0
    assert sink.payloads["battery"] == [bag_scene.battery(10)]


def test_a_pause_that_nothing_can_end_is_refused(
    bag: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Path(os.devnull).open() as nobody:
        monkeypatch.setattr(sys, "stdin", nobody)
        assert "--start-paused needs a terminal" in refusal("play", bag, "--start-paused")


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


def test_nodes_with_use_sim_time_get_the_time_of_the_recording(tmp_path: Path) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    sink = FakeSink()
    with receiving(sink, {"custom": {}}) as server:
        options = (str(write_custom(tmp_path / "bag")), *to(server), "--loop", "--clock")
        with (
            Child("-m", "ml2_receiver", "play", *options) as player,
            Child("-c", CLOCK) as node,
        ):
            assert 0 < int(node.line()) < 2 * 10**9
            assert player.end() == 0
