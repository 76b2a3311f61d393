"""Ctrl-C interrupts a command once, and the process then ends without a traceback or a crash."""

import pytest

from ros_processes import Child

pytest.importorskip("rclpy", reason="rclpy is not installed")

BEGIN = """
import atexit, os, signal, sys, threading, time
from ml2_receiver import cli

def interrupt():
    os.kill(os.getpid(), signal.SIGINT)

"""
# Has an object that Python's own end destroys.
HALFWAY = """
class Left:
    def __del__(self):
        print("destroyed", flush=True)

left = Left()
atexit.register(print, "tidied up", flush=True)
cli._run = lambda _: interrupt()
sys.exit(cli.main())
"""


def test_an_interrupted_command_destroys_nothing_that_threads_of_ros_may_use() -> None:
    with Child("-c", BEGIN + HALFWAY) as child:
        assert child.wait() == 130
        assert child.line() == "tidied up"
        assert not child.has_line(0)
        assert child.errors == []


CLOSING = """
def run(_):
    try:
        interrupt()
    finally:
        interrupt()
        print("closed", flush=True)

cli._run = run
sys.exit(cli.main())
"""


def test_what_an_interrupted_command_closes_is_not_interrupted_again() -> None:
    with Child("-c", BEGIN + CLOSING) as child:
        assert child.wait() == 130
        assert child.line() == "closed"
        assert child.errors == []


# As pybind11 does while a module of C++ is imported.
CONVERTED = """
def run(_):
    try:
        interrupt()
    except KeyboardInterrupt as error:
        raise ImportError("initialization failed") from error

cli._run = run
sys.exit(cli.main())
"""


def test_an_interrupt_that_a_library_makes_another_error_has_no_traceback() -> None:
    with Child("-c", BEGIN + CONVERTED) as child:
        assert child.wait() == 130
        assert child.errors == []


# Python's end waits for this thread.
ENDED = """
def late():
    threading.main_thread().join()
    # A signal that comes just before Python waits is heard only after that
    while True:
        interrupt()
        time.sleep(0.01)

threading.Thread(target=late).start()
cli._run = lambda _: 0
sys.exit(cli.main())
"""


def test_ctrl_c_after_the_command_ends_the_process_without_a_traceback() -> None:
    with Child("-c", BEGIN + ENDED) as child:
        assert child.wait() == 130
        assert child.errors == []


# The main thread is interrupted where it waits for the thread of a node, and destroys the node.
JOINING = """
import types
from ml2_receiver.commands.stopping import limit_interrupts
from ml2_receiver.ros import raw_taker
from ml2_tools.live.diagnostics_node import DiagnosticsNode

class WaitSet(raw_taker._rclpy.WaitSet):
    def wait(self, nanos):
        joining.wait()
        # A signal that comes just before the main thread waits is heard only after that
        while not destroyed.wait(0.01):
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        super().wait(nanos)
        waited.set()

def join(thread, real=threading.Thread.join):
    joining.set()
    real(thread)

joining, destroyed, waited = threading.Event(), threading.Event(), threading.Event()
raw_taker._rclpy = types.SimpleNamespace(
    WaitSet=WaitSet, GuardCondition=raw_taker._rclpy.GuardCondition
)
threading.Thread.join = join
node = DiagnosticsNode()
limit_interrupts()
try:
    node.close()
except KeyboardInterrupt:
    destroyed.set()
    waited.wait()
    print("waited", flush=True)
"""


def test_ctrl_c_while_a_node_ends_destroys_nothing_for_which_its_thread_waits() -> None:
    with Child("-c", BEGIN + JOINING) as child:
        assert child.wait() == 0
        assert child.line() == "waited"
        assert child.errors == []
