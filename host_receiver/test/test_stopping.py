import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from ros_processes import Child, Client, Receiver, Subscriber

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


# As a program that calls the command line again and again.
AGAIN = """
import os, threading
from ml2_receiver.commands.stopping import stop_signal

def count():
    return len(os.listdir("/proc/self/fd")), threading.active_count()

stop_signal()
before = count()
for _ in range(10):
    stopping = stop_signal()
print(count() == before, flush=True)
stopping.wait()
"""


def test_commands_of_one_process_share_what_hears_signals() -> None:
    with Child("-c", AGAIN) as child:
        assert child.line() == "True"
        assert child.end() == 0


# As a call of Fast DDS that never ended: no thread of Python runs any more.
LOCKED = """
import ctypes
from ml2_receiver.commands.stopping import stop_signal

stopping = stop_signal()
print("waits", flush=True)
stopping.wait()
ctypes.PyDLL(None).sleep(1000)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_call_that_keeps_pythons_lock_does_not_keep_the_process(number: signal.Signals) -> None:
    with Child("-c", LOCKED) as child:
        assert child.line() == "waits"
        assert child.end(number) == 1


# Python only writes what the callback of a weak reference raises.
CALLBACK = """
import threading, weakref
from ml2_receiver.commands.stopping import limit_interrupts

class Thing:
    pass

def waits(_):
    print("waits", flush=True)
    threading.Event().wait()

limit_interrupts()
thing = Thing()
reference = weakref.ref(thing, waits)
try:
    del thing
    threading.Event().wait()
except KeyboardInterrupt:
    pass
"""


def test_an_interrupt_of_a_callback_that_cannot_raise_comes_again() -> None:
    with Child("-c", CALLBACK) as child:
        assert child.line() == "waits"
        assert child.end(signal.SIGINT) == 0
        assert child.errors == []


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
sys.exit(cli.main(["work"]))
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


# Gets Ctrl-C while the module of the command line is looked for.
IMPORTING = """
import os, runpy, signal, sys

class Interrupting:
    @staticmethod
    def find_spec(name, *_):
        if name == "ml2_receiver.cli":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupting)
runpy.run_module("ml2_receiver", run_name="__main__")
"""


def test_ctrl_c_while_modules_are_imported_has_no_traceback() -> None:
    with Child("-c", IMPORTING) as child:
        assert child.wait() == -signal.SIGINT
    assert child.errors == []
