"""Every command ends cleanly: by a signal, whatever hangs, and when nobody reads its output."""

import os
import signal
import struct
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from importlib.metadata import entry_points
from pathlib import Path
from subprocess import DEVNULL, PIPE

import pytest

from configurations import only
from forked import ForkedPython
from mock_device import MockDevice
from repeated import begin, connected, repeated
from ros_processes import Child, Receiver, environment
from waiting import GRACE_S, LIMIT_S

pytest.importorskip("rclpy", reason="rclpy is not installed")

from ml2_receiver.stop_limit import STOP_S

CONFIG = only("world_left: {enabled: true}, battery: {enabled: true}")
COMMANDS = sorted({it.name for it in entry_points(group="ml2_receiver.commands")})
LISTEN = "--name other --listen 127.0.0.1:0 --insecure"
# Commands that go on until they are stopped, and what each says when it works.
LASTING = {
    f"run {LISTEN}": "listening on",
    f"run --no-ros --zenoh tcp/127.0.0.1:9 {LISTEN}": "listening on",
    f"record NEW {LISTEN}": "until Ctrl-C",
    f"record NEW --no-ros {LISTEN}": "until Ctrl-C",
    "record NEW --attach": "until Ctrl-C",
    "pair --listen 127.0.0.1:0": "ml2s://",
    "products": "ready",
    "compat": "ready",
    "topics": "watching until Ctrl-C",
    "latency": "measuring until Ctrl-C",
    "echo battery": "---",
    "evaluate --live --camera world_left --out NEW": "until Ctrl-C",
    "play BAG --insecure --receiver SPARE --rate 0.01": "playing",
    "view --no-browser": "open http",
    "view --no-browser BAG": "open http",
}
# Their exit code where it is not 0: nobody was paired, nothing recorded, or not all played.
INCOMPLETE = {"pair": 2, "evaluate": 2, "play": 1}
# Commands that end by themselves.
BRIEF = (
    "calibrate imu --forget",
    "call start",
    "config show",
    "devices --json",
    "doctor",
    "export --bag BAG --cameras world_left --kalibr NEW",
    "headset status",
    "inspect BAG",
    "messages std_msgs --language kotlin --out NEW",
    "rviz --out NEW",
    "set battery.enabled=true",
    "unpair nobody",
)
PRINTING = (
    "config show --json",
    "devices",
    "doctor --json",
    "echo battery --once",
    "evaluate --bag BAG --camera world_left --out NEW",
    "inspect BAG --json",
    "latency --once --duration 1",
    "topics --once",
    *(f"{command} --help" for command in COMMANDS),
    *("--help", "--print-completion bash"),
)
# Commands that wait for a receiver, which is not there.
WAITING = (
    "call start --name nobody",
    "devices --name nobody",
    "latency --name nobody",
    "record NEW --attach --name nobody",
    "set battery.enabled=true --name nobody",
    "topics --name nobody",
    "view --no-browser --name nobody",
)
both_signals = pytest.mark.parametrize(
    "number", [signal.SIGINT, signal.SIGTERM], ids=lambda it: it.name
)


def publishing(device: MockDevice) -> AbstractContextManager[None]:
    def publish() -> None:
        now_ns = time.time_ns()
        stamp = struct.pack("<iI", *divmod(now_ns, 1_000_000_000))
        payload = b"\x00\x01\x00\x00" + stamp + bytes(200)
        device.publish("battery", payload, capture_ns=now_ns, send_ns=now_ns)

    return repeated(connected(device, publish), 0.02)


@pytest.fixture(scope="module")
def spare(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a receiver without a headset, beside one whose headset publishes."""
    config = tmp_path_factory.mktemp("shown") / "config.yaml"
    config.write_text(CONFIG)
    with (
        Receiver(config) as receiver,
        Receiver(config, "--name", "spare") as spare,
        MockDevice(receiver.address, says_ping=True) as device,
    ):
        begin(device)
        with publishing(device):
            yield spare.address


@pytest.fixture
def given(spare: str, bag: Path, tmp_path: Path) -> dict[str, str]:
    """Returns the file or address for each word in capitals of the commands above."""
    return {"BAG": str(bag), "NEW": str(tmp_path / "new"), "SPARE": spare}


@contextmanager
def started(words: str, given: dict[str, str], *program: str) -> Iterator[Child]:
    with Child(*program, *(given.get(it, it) for it in words.split())) as child:
        yield child


def script(folder: Path, code: str) -> str:
    """Returns a file with it, which starts as a fork: what it tests comes after the imports."""
    file = folder / "script.py"
    file.write_text(code)
    return str(file)


def await_ready(child: Child, words: str) -> None:
    if words.startswith("evaluate"):  # whose output is its result
        child.await_error(LASTING[words])
    else:
        while LASTING[words] not in child.line():
            pass


def assert_ends_in_time(child: Child, number: signal.Signals) -> int:
    """Returns the exit code."""
    began_s = time.monotonic()
    code = child.end(number)
    assert time.monotonic() - began_s < STOP_S + GRACE_S
    assert not has_traceback(child.errors)
    return code


def has_traceback(lines: list[str]) -> bool:
    unclean = ("Traceback", "Exception ignored", "Task was destroyed")
    return any(it in line for it in unclean for line in lines)


def test_each_command_is_here_and_stops_within_5_s() -> None:
    assert sorted({it.split()[0] for it in (*LASTING, *BRIEF)}) == COMMANDS
    assert STOP_S < 5


@both_signals
@pytest.mark.parametrize("words", LASTING)
def test_a_signal_ends_a_command_that_lasts(
    words: str, number: signal.Signals, given: dict[str, str]
) -> None:
    with started(words, given, "-m", "ml2_receiver") as child:
        await_ready(child, words)
        assert assert_ends_in_time(child, number) == INCOMPLETE.get(words.split()[0], 0)


# Its main thread hangs where it comes to work.
MAIN_HANGS = """
import sys, threading
from ml2_receiver import cli

def hang(frame, event, _):
    file = frame.f_code.co_filename
    if event == "call" and "/ml2_" in file and "/commands/" not in file and is_parsed:
        sys.setprofile(None)
        print("hangs", flush=True)
        # A signal that comes just before the call is heard only after it
        while not forever.acquire(timeout=1):
            pass

def command_line(arguments, real=cli.command_line):
    parser = real(arguments)
    parsed = parser.parse_args(arguments)
    parser.parse_args = lambda _: is_parsed.append(True) or parsed
    return parser

cli.command_line, is_parsed, forever = command_line, [], threading.Lock()
forever.acquire()
sys.setprofile(hang)
sys.exit(cli.main())
"""


@both_signals
@pytest.mark.parametrize("words", BRIEF)
def test_a_signal_ends_a_command_whose_main_thread_hangs(
    words: str, number: signal.Signals, given: dict[str, str]
) -> None:
    with started(words, given, "-c", MAIN_HANGS) as child:
        while child.line() != "hangs":
            pass
        assert assert_ends_in_time(child, number) in (130, -signal.SIGTERM)


# Each thread but the main one and that of signals hangs at its next call: once this is told to, or
# from its beginning with the environment's HANG.
THREADS_HANG = f"""
import os, sys, threading
from ml2_receiver import stop_limit
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

stop_limit.STOP_S = {STOP_S}
forever, hung = threading.Lock(), set()
forever.acquire()
if "HANG" in os.environ:
    threading.setprofile(hang)
else:
    threading.Thread(target=tell, name="teller", daemon=True).start()
sys.exit(main())
"""


# echo has no other thread.
@pytest.mark.parametrize("words", [it for it in LASTING if not it.startswith("echo")])
def test_a_command_that_lasts_ends_whatever_thread_hangs(
    words: str, given: dict[str, str], tmp_path: Path
) -> None:
    with started(words, given, script(tmp_path, THREADS_HANG)) as child:
        await_ready(child, words)
        assert child.process.stdin is not None
        child.process.stdin.write("hang\n")
        child.process.stdin.flush()
        while not child.line().startswith("hangs"):
            pass
        assert assert_ends_in_time(child, signal.SIGTERM) in (0, 1, 2)


@pytest.mark.parametrize("words", WAITING)
def test_ctrl_c_ends_a_command_that_waits_whatever_thread_hangs(
    words: str, given: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HANG", "1")
    with started(words, given, script(tmp_path, THREADS_HANG)) as child:
        while not child.line().startswith("hangs"):
            pass
        assert assert_ends_in_time(child, signal.SIGINT) in (0, 130, 2)


# Says when another thread works, which is that of the node which hears receivers.
NODE_HEARS = """
import sys, threading
from ml2_receiver.cli import main

def say(*_):
    if threading.current_thread().name == "raw-taker":
        sys.setprofile(None)
        print("hears", flush=True)

threading.setprofile(say)
sys.exit(main())
"""


@pytest.mark.parametrize("words", WAITING)
def test_ctrl_c_ends_a_command_that_waits_and_nothing_hangs(
    words: str, given: dict[str, str], tmp_path: Path
) -> None:
    with started(words, given, script(tmp_path, NODE_HEARS)) as child:
        while child.line() != "hears":
            pass
        assert assert_ends_in_time(child, signal.SIGINT) in (0, 130)
        assert child.errors == []


EVERY = (*LASTING, *BRIEF)
WRAPPER = str(Path(__file__).resolve().parents[1] / "ml2-receiver")
# The first moments are those at which Python starts.
MOMENTS = [(words, 0.02 * at) for at, words in enumerate(EVERY)] + [
    (words, 0.02 * len(EVERY) + 0.04 * at) for at, words in enumerate(EVERY)
]


@pytest.mark.parametrize(("words", "after_s"), MOMENTS)
def test_ctrl_c_at_any_moment_after_the_start_has_no_traceback(
    words: str, after_s: float, given: dict[str, str]
) -> None:
    with Child(*(given.get(it, it) for it in words.split()), program=WRAPPER) as child:
        threading.Event().wait(after_s)
        code = child.end(signal.SIGINT)
        assert not has_traceback(child.errors)
        assert code in (0, INCOMPLETE.get(words.split()[0], 0), 1, 2, 130, -signal.SIGINT)


# NumPy prints an error of its import in an extension, and then raises ImportError.
IMPORTS_ARRAY = """
import builtins, os, signal, sys
from ml2_receiver.commands.stopping import run_interruptible

import numpy
unchanged = builtins.__import__

def interrupt(name, *rest, **more):
    if name == "numpy._core._multiarray_umath":
        builtins.__import__ = unchanged
        print("imports", flush=True)
        os.kill(os.getpid(), signal.SIGINT)
    return unchanged(name, *rest, **more)

def command():
    builtins.__import__ = interrupt
    import cv2
    return 0

sys.exit(run_interruptible(command))
"""


def test_ctrl_c_while_an_extension_imports_numpy_has_no_traceback() -> None:
    with Child("-c", IMPORTS_ARRAY) as child:
        assert child.line() == "imports"
        assert child.process.wait(LIMIT_S) == 130
    assert child.errors == []


def test_the_script_hears_no_ctrl_c_that_it_would_lose(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = tmp_path / "start.sh"
    start.write_text("echo waits >&2\nread -r _")
    monkeypatch.setenv("BASH_ENV", str(start))
    with Child("run", *LISTEN.split(), program=WRAPPER) as child:
        child.await_error("waits")
        status = Path(f"/proc/{child.process.pid}/status").read_text()
        (blocked,) = (it.split()[1] for it in status.splitlines() if it.startswith("SigBlk:"))
        assert child.process.stdin is not None
        child.process.stdin.close()  # so that the script goes on
        assert int(blocked, 16) & 1 << signal.SIGINT - 1


@contextmanager
def started_as_fork(words: str, given: dict[str, str], stdout: int) -> Iterator[ForkedPython]:
    named = (given.get(it, it) for it in words.split())
    with ForkedPython(
        [sys.executable, "-m", "ml2_receiver", *named],
        env=environment(),
        stdin=DEVNULL,
        stdout=stdout,
        stderr=PIPE,
        text=True,
    ) as child:
        try:
            yield child
        finally:
            child.kill()


def code_without_traceback(child: ForkedPython) -> int:
    _, errors = child.communicate(timeout=LIMIT_S)
    assert not has_traceback(errors.splitlines())
    return child.returncode


# evaluate says on standard error that it works.
@pytest.mark.parametrize("words", [it for it in LASTING if not it.startswith("evaluate")])
def test_a_command_that_lasts_ends_when_nobody_reads_its_output_any_more(
    words: str, given: dict[str, str]
) -> None:
    with started_as_fork(words, given, PIPE) as child:
        assert child.stdout is not None
        assert any(LASTING[words] in line for line in child.stdout)
        child.stdout.close()
        child.send_signal(signal.SIGINT)
        # 1 of rich, which sees it first.
        allowed = (0, INCOMPLETE.get(words.split()[0], 0), 1, 141, -signal.SIGPIPE)
        assert code_without_traceback(child) in allowed


@pytest.mark.parametrize("words", [*BRIEF, *PRINTING])
def test_a_command_whose_output_nobody_reads_has_no_traceback(
    words: str, given: dict[str, str]
) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with started_as_fork(words, given, writing) as child:
        os.close(writing)
        # 0 of argparse, 1 of rich, which see it first; 2 of what fails before it prints.
        assert code_without_traceback(child) in (0, 1, 2, 141, -signal.SIGPIPE)
