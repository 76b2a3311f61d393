import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from ml2_receiver.stop_limit import STOP_S
from ros_processes import Child, Client, Receiver, Subscriber
from waiting import GRACE_S

CONFIG = "/**: {ros__parameters: {battery: {enabled: true}}}"

# The kernel may give a signal to any thread; here it cannot give it to the one that waits.
PROGRAM = """
import signal
import threading
from ml2_receiver.commands.stopping import stop_signal

stopping = stop_signal()
threading.Thread(target=threading.Event().wait, daemon=True).start()
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
print("waits", flush=True)
stopping.wait()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_another_thread_gets_ends_the_wait(number: signal.Signals) -> None:
    with Child("-c", PROGRAM) as child:
        assert child.line() == "waits"
        assert child.end(number) == 0


@pytest.fixture
def background_job() -> Iterator[None]:
    """Children start as those of a shell without job control do."""
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield
    signal.signal(signal.SIGINT, handler)


COMMAND = """
import sys
import threading
from ml2_receiver.cli import main

assert main(sys.argv[1:]) == 0
print("waits", flush=True)
threading.Event().wait()
"""


@pytest.mark.usefixtures("background_job")
def test_ctrl_c_ends_any_command_of_a_background_job(config: Path) -> None:
    with Child("-c", COMMAND, "config", "check", str(config)) as child:
        while child.line() != "waits":
            pass
        assert child.end() == -signal.SIGINT


@pytest.mark.usefixtures("background_job")
def test_ctrl_c_ends_receivers_and_test_programs_of_a_background_job(config: Path) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    with (
        Receiver(config) as receiver,
        Client() as client,
        Subscriber("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray") as subscriber,
    ):
        assert client.ask("get", "battery.enabled") == [True]
        assert client.end() == -signal.SIGINT
        assert subscriber.end() == 0
        assert receiver.end() == 0


# Once it is told to, each thread but the main one and that of signals hangs at its next call.
HANGING = """
import sys
import threading
from ml2_receiver.cli import main

def hang(*_):
    if threading.current_thread().name not in ("MainThread", "signals", "teller"):
        if threading.current_thread() not in hung:
            hung.add(threading.current_thread())
            print("hangs", threading.current_thread().name, flush=True)
        forever.acquire()

def tell():
    sys.stdin.readline()
    threading.setprofile_all_threads(hang)

forever, hung = threading.Lock(), set()
forever.acquire()
threading.Thread(target=tell, name="teller", daemon=True).start()
sys.exit(main(sys.argv[1:]))
"""
LISTEN = ("--listen", "127.0.0.1:0", "--insecure")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    ("words", "ready"),
    [
        (("run", *LISTEN), "listening on"),
        (("record", "bag", *LISTEN), "listening on"),
        (("record", "bag", *LISTEN, "--no-ros"), "listening on"),
        (("products",), "ready"),
        (("compat",), "ready"),
        (("pair", "--listen", "127.0.0.1:0"), "ml2"),
    ],
    ids=lambda it: " ".join(it[:1]) if isinstance(it, tuple) else "",
)
def test_a_command_ends_whatever_hangs(
    words: tuple[str, ...],
    ready: str,
    number: signal.Signals,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    monkeypatch.chdir(tmp_path)
    with Child("-c", HANGING, *words) as child:
        while ready not in child.line():
            pass
        assert child.process.stdin is not None
        child.process.stdin.write("hang\n")
        child.process.stdin.flush()
        while not child.line().startswith("hangs"):
            pass
        began_s = time.monotonic()
        assert child.end(number) in (0, 2)
        assert time.monotonic() - began_s < STOP_S + GRACE_S


# The limit of the first stop passes while the command works on.
WORKING_ON = """
import argparse, sys, time
from ml2_receiver import cli, stop_limit
from ml2_receiver.commands.stopping import go_on, stop_signal

def work(_):
    stopping = stop_signal()
    print("waits", flush=True)
    stopping.wait()
    go_on()
    time.sleep(1)
    print("works on", flush=True)
    time.sleep(1000)

stop_limit.STOP_S = 0.5
parser = argparse.ArgumentParser()
parser.parse_args = lambda _: argparse.Namespace(run=work)
cli.command_line = lambda _: parser
sys.exit(cli.main([]))
"""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, -15)])
def test_a_command_that_works_on_after_its_stop_is_ended_by_the_next_signal(
    number: signal.Signals, code: int
) -> None:
    with Child("-c", WORKING_ON) as child:
        assert child.line() == "waits"
        child.process.send_signal(signal.SIGINT)
        assert child.line() == "works on"
        assert child.end(number) == code
    assert child.errors == []
