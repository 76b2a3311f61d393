"""Runs receiver, headset and subscriber as processes in an isolated ROS domain."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import subprocess
import sys
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from rclpy.serialization import deserialize_message

import drawing
from forked import ForkedPython
from left_out import left_out
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.message_types import message_class
from ml2_tools.selftest.pairing import pair
from payload_file import Payloads
from proxy import Proxy
from ros_domain import reserve_domain
from waiting import LIMIT_S, await_true

ROOT = Path(__file__).resolve().parents[2]
_MOST_RUNS = 6
RECEIVER = ROOT / "host_receiver" / "ml2-receiver"
HEADSET = ROOT / "ml2-sensors-aar" / "simulator" / "ml2-headset"
EXCERPT = ROOT.parent / "shared" / "data" / "euroc_v1_01_excerpt"
PREFIX = "/magic_leap2"
_LISTENING = "listening on "
# To read a recording again and again costs more than the session that it is of.
PAUSE_S = 0.25
# More messages than are ever in flight, so that the subscriber loses none that were published.
_DEPTH = 1000
PATHS = {
    "PYTHONPATH": os.pathsep.join(
        str(ROOT / "host_receiver" / folder) for folder in (".", "demo", "test")
    )
}
# The JVM's mDNS library searches on this network.
ON_LOOPBACK = {"JDK_JAVA_OPTIONS": "-Dnet.mdns.interface=127.0.0.1"}


@dataclass(frozen=True)
class Security:
    """Security options of a receiver, and the matching options of a headset."""

    receiver: Sequence[str | Path]
    headset: Sequence[str | Path]


_INSECURE = ("--insecure", "--insecure-eye-images")
PLAINTEXT = Security(_INSECURE, _INSECURE)


def paired(folder: Path) -> Security:
    """Pairs a receiver and a headset; returns their options, with keys in `folder`."""
    keys = with_keys(folder)
    pair([RECEIVER, "pair", *keys.receiver], [HEADSET, *keys.headset])
    return keys


def with_keys(folder: Path) -> Security:
    """Returns the options of a receiver and a headset that have their keys in `folder`."""
    return Security(("--keys", folder / "receiver"), ("--keys", folder / "headset"))


@dataclass(frozen=True)
class Received:
    """The messages and statistics that the independent subscriber got in one run.

    Attributes:
        snapshot: the last snapshot of the demo's observer.
        qos: reliability and durability of each topic's publishers.
        topics: the type and the payloads of each topic.
        graph: the names of all topics in the ROS domain.
        arrivals_s: the arrival of each message, by the monotonic clock.
        publishers: the ids of all publishers that each topic had.
        diagnostics: the payloads of /diagnostics.
    """

    snapshot: dict[str, Any]
    qos: dict[str, set[tuple[str, str]]]
    topics: dict[str, tuple[str, Payloads | list[bytes]]]
    graph: list[str]
    arrivals_s: dict[str, list[float]]
    publishers: dict[str, set[bytes]]
    diagnostics: list[bytes]

    def messages(self, topic: str) -> list[Any]:
        """Returns the decoded messages of a topic, named below the prefix or absolutely."""
        message_type, payloads = self.topics[full_name(topic)]
        return [deserialize_message(payload, message_class(message_type)) for payload in payloads]

    def counters(self, topic: str) -> dict[str, str]:
        """Returns the last diagnostics of a topic."""
        counters: dict[str, str] = self.snapshot["topics"][topic]["diagnostics"]
        return counters


def full_name(topic: str) -> str:
    """Returns the name of a topic that is named below the prefix or absolutely."""
    return topic if topic.startswith("/") else f"{PREFIX}/{topic}"


def isolated_environment() -> dict[str, str]:
    """Returns environment variables with a ROS domain for the processes of one test."""
    return os.environ | {
        "ROS_DOMAIN_ID": str(reserve_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }


def start(command: Sequence[str | Path], **options: Any) -> subprocess.Popen[str]:
    """Starts a child process whose streams are text, with other options of Popen.

    In tests, a receiver or another Python program is a fork, which starts at once.
    """
    words = [str(word) for word in command]
    if words[0] == str(RECEIVER):
        python = [sys.executable, "-m", "ml2_receiver", *words[1:]]
    else:
        python = words
    is_forked = "pytest" in sys.modules and python[0] == sys.executable and python[1] != "-c"
    if is_forked:
        return ForkedPython(python, text=True, **options)
    return subprocess.Popen(words, text=True, **options)


def ended(
    command: Sequence[str | Path], environment: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Starts a child process, and returns what it printed when it has ended."""
    pipe = subprocess.PIPE
    with start(command, env=environment, stdout=pipe, stderr=pipe) as child:
        try:
            output, errors = child.communicate(timeout=3 * LIMIT_S)
        finally:
            child.kill()
    print(errors, file=sys.stderr)  # which pytest shows if the test failed
    return subprocess.CompletedProcess(child.args, child.returncode, output, errors)


@contextlib.contextmanager
def process(
    command: Sequence[str | Path],
    environment: dict[str, str],
    log: Path,
    stdin: int | None = None,
    *,
    is_read: bool = True,
) -> Iterator[subprocess.Popen[str]]:
    """Runs a child process whose standard output is text; terminates it at the end.

    Its standard error, and the rest of its standard output, go to `log`. Unless the caller reads
    the output (`is_read`), all of it goes there at once: a full pipe would stop the child.
    """
    with log.open("w") as errors:
        child = start(
            command,
            env=environment,
            stdin=stdin,
            stdout=subprocess.PIPE if is_read else errors,
            stderr=errors,
        )
        try:
            yield child
        finally:
            child.terminate()
            try:
                output, _ = child.communicate(timeout=LIMIT_S)
            except subprocess.TimeoutExpired:
                child.kill()
                raise
            errors.write(output or "")


def listening_address(receiver: subprocess.Popen[str]) -> str:
    """Waits until a receiver prints its address, and returns it as HOST:PORT."""
    return line_with(receiver, _LISTENING).split(_LISTENING, 1)[1].split()[0]


def receive(
    config: Path, headset_options: list[str], folder: Path, *more: Any, **options: Any
) -> Received:
    """Runs a headset to its end and returns all received messages, as receive_once().

    A headset that left images out to draw them, since its cache has lost them, draws them and runs
    again, unless the test takes part in the run.
    """
    for _ in range(_MOST_RUNS):
        received = receive_once(config, headset_options, folder, *more, **options)
        takes_part = more or {"link", "is_enough"} & options.keys()
        if takes_part or not left_out(folder / "headset.log"):
            break
        drawing.forget(config, headset_options)
    return received


def receive_once(
    config: Path,
    headset_options: list[str],
    folder: Path,
    link: Callable[[str], Proxy] | None = None,
    receiver_options: Sequence[str] = (),
    program: Sequence[str | Path] = (HEADSET,),
    security: Security = PLAINTEXT,
    is_enough: Callable[[dict[str, Any]], bool] | None = None,
) -> Received:
    """Runs a headset to its end and returns all received messages; logs are in `folder`.

    Args:
        headset_options: options of ml2-headset, which `program` starts.
        link: makes the proxy between headset and receiver, from the receiver's address.
        is_enough: gets a snapshot four times per second, and returns True to end the headset; it
            ends after LIMIT_S otherwise.
    """
    if tuple(program) == (HEADSET,):
        draw_images(config, headset_options)
    environment = isolated_environment()
    with contextlib.ExitStack() as stack:
        start = stack.enter_context
        receiver = start(
            process(
                receive_command(
                    config,
                    "127.0.0.1:0",
                    *("--start-paused", *receiver_options),
                    security=security,
                ),
                environment,
                folder / "receiver.log",
            )
        )
        subscriber = start(subscribing(environment, folder))
        address = listening_address(receiver)
        destination = start(link(address)).address if link else address
        headset = [*program, "--receiver", destination, *security.headset, *headset_options]
        headset += ["--duration", f"{LIMIT_S}"] if is_enough else []
        running = start(process(headset, environment, folder / "headset.log"))
        snapshots = _from_first_message(map(json.loads, lines(subscriber)), running)
        for snapshot in snapshots:
            if is_enough and is_enough(snapshot):
                running.terminate()
        return result(subscriber, folder)


def draw_images(config: Path, headset_options: Sequence[str]) -> None:
    """Renders all images of a run into the headset's cache, unless they are there."""
    note = drawing.note(config, headset_options)
    if note is None or note.exists():
        return
    note.parent.mkdir(parents=True, exist_ok=True)
    # Without a limit of its own: the images of a long walk take minutes.
    with start(drawing.command(config, headset_options), stdout=subprocess.PIPE) as drawer:
        try:
            said, _ = drawer.communicate()
        finally:
            drawer.kill()
    assert drawer.returncode == 0, "standard error says why"
    if said:
        note.touch()


def recorded_walk(
    config: Path,
    folder: Path,
    is_enough: Callable[[Path], bool],
    *headset_options: str,
    security: Security = PLAINTEXT,
) -> Path:
    """Records a headset without ROS until that is enough; returns the bag, beside the logs."""
    walk, environment = folder / "walk", isolated_environment()
    record: list[str | Path] = [RECEIVER, "record", walk, "--no-ros", "--config", config]
    record += ["--listen", "127.0.0.1:0", *security.receiver]
    with process(record, environment, folder / "receiver.log") as receiver:
        address = listening_address(receiver)
        headset = headset_command(address, *headset_options, security=security)
        with process(headset, environment, folder / "headset.log", is_read=False):
            await_true(lambda: is_enough(walk), PAUSE_S)
    return walk


def _from_first_message(
    snapshots: Iterator[dict[str, Any]], headset: subprocess.Popen[str]
) -> Iterator[dict[str, Any]]:
    for snapshot in snapshots:
        if any(topic["count"] for topic in snapshot["topics"].values()):
            yield snapshot
        else:
            assert headset.poll() is None, "the headset has ended without a message: headset.log"


def subscribing(
    environment: dict[str, str], folder: Path, receiver: str = ""
) -> contextlib.AbstractContextManager[subprocess.Popen[str]]:
    """Runs the subscriber as a process; result() reads its result from `folder`."""
    command = subscribe_command(folder / "received.pickle", receiver)
    return process(command, environment | PATHS, folder / "subscriber.log")


def lines(child: subprocess.Popen[str]) -> IO[str]:
    """Returns the child's standard output, for iteration by line."""
    assert child.stdout is not None
    return child.stdout


def line_with(child: subprocess.Popen[str], words: str) -> str:
    """Waits for a line that contains `words`, and returns it."""
    earlier = []
    for line in lines(child):
        earlier.append(line)
        if words in line:
            return line
    raise AssertionError(f"expected {words!r}, found {''.join(earlier)!r}")


def result(subscriber: subprocess.Popen[str], folder: Path) -> Received:
    """Waits for the end of a subscriber, whose full pipe would stop it, and returns its result.

    Half a gigabyte of payloads stays in `folder` as long as the result.
    """
    subscriber.communicate(timeout=LIMIT_S)
    assert subscriber.returncode == 0, (folder / "subscriber.log").read_text()
    received = Received(**pickle.loads((folder / "received.pickle").read_bytes()))
    weakref.finalize(received, (folder / "received.payloads").unlink, missing_ok=True)
    return received


def receive_command(
    config: Path, address: str, *options: str, security: Security = PLAINTEXT
) -> list[str | Path]:
    """Returns the command of a receiver that listens on `address`."""
    return [RECEIVER, "run", "--config", config, "--listen", address, *security.receiver, *options]


def headset_command(
    address: str, *options: str, security: Security = PLAINTEXT
) -> list[str | Path]:
    """Returns the command of a headset that connects to `address`."""
    return [HEADSET, "--receiver", address, *security.headset, *options]


def subscribe_command(output: Path, receiver: str) -> list[str | Path]:
    """Returns the command of a subscriber to the receiver of that name; it writes to `output`."""
    depths = dict.fromkeys(load_table().qos, _DEPTH)
    script = Path(__file__).with_name("subscriber.py")
    prefix = f"/{receiver}{PREFIX}" if receiver else PREFIX
    return [sys.executable, script, prefix, json.dumps(depths), output, receiver]
