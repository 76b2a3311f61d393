"""Receiver, headset and subscriber as processes, isolated by domain and local discovery."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from rclpy.serialization import deserialize_message

from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.message_types import message_class
from pairing import pair
from payload_file import Payloads
from proxy import Proxy
from ros_domain import reserve_domain

ROOT = Path(__file__).resolve().parents[2]
RECEIVER = ROOT / "host_receiver" / "ml2-receiver"
HEADSET = ROOT / "ml2-sensors-aar" / "simulator" / "ml2-headset"
EXCERPT = ROOT.parent / "shared" / "data" / "euroc_v1_01_excerpt"
PREFIX = "/magic_leap2"
_LISTENING = "listening on "
_TIMEOUT_S = 60
# More than is ever under way, so that the subscriber loses nothing that was published.
_DEPTH = 1000
PATHS = {
    "PYTHONPATH": os.pathsep.join(
        [str(ROOT / "host_receiver"), str(ROOT / "host_receiver" / "demo")]
    )
}
# Of the JVM's mDNS library: which network to look on.
ON_LOOPBACK = {"JDK_JAVA_OPTIONS": "-Dnet.mdns.interface=127.0.0.1"}


@dataclass(frozen=True)
class Security:
    """Options of a receiver, and of a headset that gets along with it."""

    receiver: Sequence[str | Path]
    headset: Sequence[str | Path]


_INSECURE = ("--insecure", "--insecure-eye-images")
IN_THE_CLEAR = Security(_INSECURE, _INSECURE)


def paired(folder: Path) -> Security:
    """Those of two that have just been paired, with keys in `folder`."""
    keys = Security(("--keys", folder / "receiver"), ("--keys", folder / "headset"))
    pair([RECEIVER, "pair", *keys.receiver], [HEADSET, *keys.headset])
    return keys


@dataclass(frozen=True)
class Received:
    """What the independent subscriber got in one run."""

    snapshot: dict[str, Any]
    qos: dict[str, set[tuple[str, str]]]
    topics: dict[str, tuple[str, Payloads | list[bytes]]]
    graph: list[str]
    arrivals_s: dict[str, list[float]]
    publishers: dict[str, set[bytes]]

    def messages(self, topic: str) -> list[Any]:
        """The messages of a topic, relative to the prefix or global, as rclpy decodes them."""
        name = topic if topic.startswith("/") else f"{PREFIX}/{topic}"
        message_type, payloads = self.topics[name]
        return [deserialize_message(payload, message_class(message_type)) for payload in payloads]

    def counters(self, topic: str) -> dict[str, str]:
        """The last diagnostics of a topic."""
        counters: dict[str, str] = self.snapshot["topics"][topic]["diagnostics"]
        return counters


def isolated_environment() -> dict[str, str]:
    """Variables for one test's processes: a domain of their own on this machine."""
    return os.environ | {
        "ROS_DOMAIN_ID": str(reserve_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }


@contextlib.contextmanager
def process(
    command: Sequence[str | Path],
    environment: dict[str, str],
    log: Path,
    stdin: int | None = None,
) -> Iterator[subprocess.Popen[str]]:
    """A child whose standard output is read as text; terminated and awaited at the end."""
    with log.open("w") as errors:
        child = subprocess.Popen(
            [str(word) for word in command],
            env=environment,
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
        try:
            yield child
        finally:
            child.terminate()
            said, _ = child.communicate(timeout=_TIMEOUT_S)
            errors.write(said)


def listening_address(receiver: subprocess.Popen[str]) -> str:
    """Waits until a receiver says where it listens."""
    return line_with(receiver, _LISTENING).split(_LISTENING, 1)[1].split()[0]


def receive(
    config: Path,
    headset_options: list[str],
    folder: Path,
    link: Callable[[str], Proxy] | None = None,
    on_snapshot: Callable[[Proxy | None, int], None] = lambda _, __: None,
    receiver_options: Sequence[str] = (),
    program: Sequence[str | Path] = (HEADSET,),
    security: Security = IN_THE_CLEAR,
) -> Received:
    """Runs a headset to its end and returns all that arrived; logs are in `folder`.

    Args:
        headset_options: of the command ml2-headset, which `program` starts.
        link: makes the proxy that stands between headset and receiver, from the latter's address.
        on_snapshot: is called about once per second with the proxy and a count from 0.
    """
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
        proxy = start(link(address)) if link else None
        reached = proxy.address if proxy else address
        headset = [*program, "--receiver", reached, *security.headset, *headset_options]
        start(process(headset, environment, folder / "headset.log"))
        for number, _ in enumerate(lines(subscriber)):
            on_snapshot(proxy, number)
        return result(subscriber, folder)


def subscribing(
    environment: dict[str, str], folder: Path, receiver: str = ""
) -> contextlib.AbstractContextManager[subprocess.Popen[str]]:
    """The subscriber as a process; its result() is in `folder`."""
    command = subscribe_command(folder / "received.pickle", receiver)
    return process(command, environment | PATHS, folder / "subscriber.log")


def lines(child: subprocess.Popen[str]) -> IO[str]:
    """What it says until it ends, a line at a time."""
    assert child.stdout is not None
    return child.stdout


def line_with(child: subprocess.Popen[str], words: str) -> str:
    """The next line that has these words."""
    said = []
    for line in lines(child):
        said.append(line)
        if words in line:
            return line
    raise AssertionError(f"expected {words!r}, found {''.join(said)!r}")


def result(subscriber: subprocess.Popen[str], folder: Path) -> Received:
    """What a subscriber got; waits for its end."""
    subscriber.wait(timeout=_TIMEOUT_S)
    assert subscriber.returncode == 0, (folder / "subscriber.log").read_text()
    return Received(**pickle.loads((folder / "received.pickle").read_bytes()))


def receive_command(
    config: Path, address: str, *options: str, security: Security = IN_THE_CLEAR
) -> list[str | Path]:
    """The receiver, listening on `address`."""
    return [RECEIVER, "run", "--config", config, "--listen", address, *security.receiver, *options]


def headset_command(
    address: str, *options: str, security: Security = IN_THE_CLEAR
) -> list[str | Path]:
    """The headset, connecting to `address`."""
    return [HEADSET, "--receiver", address, *security.headset, *options]


def subscribe_command(output: Path, receiver: str) -> list[str | Path]:
    """The subscriber of a receiver of that name, which writes what it got to `output`."""
    depths = dict.fromkeys(load_table().qos, _DEPTH)
    script = Path(__file__).with_name("subscriber.py")
    prefix = f"/{receiver}{PREFIX}" if receiver else PREFIX
    return [sys.executable, script, prefix, json.dumps(depths), output, receiver]
