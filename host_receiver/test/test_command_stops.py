"""Commands that show or play until they are stopped: each ends cleanly, whatever hangs."""

from __future__ import annotations

import signal
import struct
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import pytest

from mock_device import MockDevice
from repeated import repeated
from ros_processes import Child, Receiver
from test_stopping import HANGING
from waiting import GRACE_S

pytest.importorskip("rclpy", reason="rclpy is not installed")

from ml2_receiver.stop_limit import STOP_S

CONFIG = """
/**:
  ros__parameters:
    world_left: {enabled: true}
    battery: {enabled: true}
"""
SHOWING = {
    ("topics",): "watching until Ctrl-C",
    ("latency",): "measuring until Ctrl-C",
    ("echo", "battery"): "---",
    ("view", "--no-browser"): "open http",
    ("view", "--no-browser", "BAG"): "open http",
}
# echo has no other thread.
THREADED = [it for it in SHOWING if it[0] != "echo"]
SIGNALS = [signal.SIGINT, signal.SIGTERM]


def publishing(device: MockDevice) -> AbstractContextManager[None]:
    def publish() -> None:
        now_ns = time.time_ns()
        stamp = struct.pack("<iI", *divmod(now_ns, 1_000_000_000))
        payload = b"\x00\x01\x00\x00" + stamp + bytes(200)
        device.publish("battery", payload, capture_ns=now_ns, send_ns=now_ns)

    return repeated(publish, 0.02)


@pytest.fixture(scope="module")
def headset(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    config = tmp_path_factory.mktemp("shown") / "config.yaml"
    config.write_text(CONFIG)
    with Receiver(config) as receiver, MockDevice(receiver.address, says_ping=True) as device:
        device.start()
        with publishing(device):
            yield


@contextmanager
def showing(words: tuple[str, ...], bag: Path, *program: str) -> Iterator[Child]:
    ready = SHOWING[words]
    named = [str(bag) if it == "BAG" else it for it in words]
    with Child(*program, *named) as child:
        while ready not in child.line():
            pass
        yield child


def has_traceback(child: Child) -> bool:
    return any("Traceback" in line for line in child.errors)


@pytest.mark.usefixtures("headset")
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("words", SHOWING, ids=" ".join)
def test_a_signal_ends_it_cleanly(
    words: tuple[str, ...], number: signal.Signals, bag: Path
) -> None:
    with showing(words, bag, "-m", "ml2_receiver") as child:
        began_s = time.monotonic()
        assert child.end(number) == 0
        assert time.monotonic() - began_s < STOP_S + GRACE_S
        assert not has_traceback(child)


@pytest.mark.usefixtures("headset")
@pytest.mark.parametrize("words", SHOWING, ids=" ".join)
def test_it_ends_when_nobody_reads_its_output_any_more(words: tuple[str, ...], bag: Path) -> None:
    named = [str(bag) if it == "BAG" else it for it in words]
    command = ["-m", "ml2_receiver", *named]
    with Child("-c", UNREAD, SHOWING[words], *command) as child:
        assert child.line() == "closed"
        assert child.end(signal.SIGINT) in (0, 1, 141)  # 1 of rich, which sees it first
        assert not has_traceback(child)


# Starts a command, reads its output until it is ready, closes the pipe and hands on a signal.
UNREAD = """
import signal, subprocess, sys
ready, *command = sys.argv[1:]
child = subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, text=True)
while ready not in child.stdout.readline():
    pass
child.stdout.close()
signal.signal(signal.SIGINT, lambda *_: child.send_signal(signal.SIGINT))
print("closed", flush=True)
sys.exit(child.wait() % 256 if child.wait() >= 0 else 141)
"""


@pytest.mark.usefixtures("headset")
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("words", THREADED, ids=" ".join)
def test_it_ends_whatever_hangs(words: tuple[str, ...], number: signal.Signals, bag: Path) -> None:
    with showing(words, bag, "-c", HANGING) as child:
        assert child.process.stdin is not None
        child.process.stdin.write("hang\n")
        child.process.stdin.flush()
        while not child.line().startswith("hangs"):
            pass
        began_s = time.monotonic()
        assert child.end(number) in (0, 2)
        assert time.monotonic() - began_s < STOP_S + GRACE_S


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_ends_what_plays(number: signal.Signals, bag: Path, receiver: Receiver) -> None:
    words = ("play", str(bag), "--insecure", "--receiver", receiver.address, "--rate", "0.01")
    with Child("-m", "ml2_receiver", *words) as child:
        receiver.await_error("connected from")
        began_s = time.monotonic()
        assert child.end(number) in (0, 1)
        assert time.monotonic() - began_s < STOP_S + GRACE_S
        assert not has_traceback(child)
