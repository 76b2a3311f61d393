"""Compares the ways from a topic to a client on the network: ROS-TCP-Endpoint's and the receiver's.

Usage: downlink_endpoint_bench.py RESULTS CHECKOUT DURATION REPETITIONS. Both serve one client in
plaintext on the same machine, in turns of DURATION seconds. Of the small messages, 1000 of 100
bytes come per second, of the large ones 30 of 1 MB. Writes to RESULTS, for `small` and `large`:

SERVER_SIZE_latency_p50_ms     from the call of publish() to the last byte at the client; also p99
SERVER_SIZE_cpu_us_per_message the CPU time of the server's processes
SERVER_SIZE_lost               messages that did not come within 5 s after the last one
latency_ratio_to_endpoint_SIZE, cpu_ratio_to_endpoint_SIZE: the receiver's part of the endpoint's,
                               the median of the repetitions
ratio_to_endpoint_SIZE         the greater of the two: below 1, the receiver needs less of both
"""

import json
import os
import socket
import struct
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
import yaml

from endpoint import connect, subscription
from ml2_receiver.wire.frame import HEADER_BYTES, Header
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.opening_bodies import Open
from mock_device import MockDevice
from players import Player
from processes import isolated_environment, listening_address, process, receive_command

_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_QUIET_S = 5.0
_HEADER = struct.Struct("<HBBHHIIqq")
_STAMP_DIGITS = 20


class _Size(NamedTuple):
    """Messages that roles.play_publisher makes; the stamp begins after so many bytes of CDR."""

    type: str
    rate_hz: int
    publisher: list[str]
    stamp_at: int


_SIZES = {
    "small": _Size("std_msgs/msg/String", 1000, [], 8),
    "large": _Size("std_msgs/msg/UInt8MultiArray", 30, ["1000000"], 16),
}


class Arrivals:
    """The latencies of the messages that a thread reads from a connection."""

    def __init__(self, read: Callable[[], bytearray], size: _Size) -> None:
        self.latencies_ns: list[int] = []
        self._stamp = slice(size.stamp_at, size.stamp_at + _STAMP_DIGITS)
        self._read = read
        self._changed = threading.Condition()
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        while message := self._read():
            latency_ns = time.monotonic_ns() - int(message[self._stamp])
            with self._changed:
                self.latencies_ns.append(latency_ns)
                self._changed.notify()

    def wait(self, count: int) -> None:
        """Waits until so many have come, or none comes any more."""
        with self._changed:
            while len(self.latencies_ns) < count and self._changed.wait(_QUIET_S):
                pass


class Figures(NamedTuple):
    latency_p50_ms: float
    latency_p99_ms: float
    cpu_us_per_message: float
    lost: int


class Turn:
    """A server whose client reads the messages of one publisher."""

    def __init__(self, arrivals: Arrivals, publisher: Player, cpu_s: Callable[[], float]) -> None:
        self.results: list[Figures] = []
        self._arrivals, self._publisher, self._cpu_s = arrivals, publisher, cpu_s

    def play(self, messages: int) -> None:
        self._arrivals.latencies_ns.clear()
        before_s = self._cpu_s()
        self._publisher.usage(messages)
        self._arrivals.wait(messages)
        cpu_us = (self._cpu_s() - before_s) * 1e6 / messages
        latencies_ns = list(self._arrivals.latencies_ns)
        p50, p99 = np.percentile(latencies_ns, (50, 99)) / 1e6
        self.results.append(Figures(p50, p99, cpu_us, messages - len(latencies_ns)))


def main(results: Path, checkout: str, duration_s: float, repetitions: int) -> None:
    os.environ |= isolated_environment()
    found: dict[str, object] = {"duration_s": duration_s, "repetitions": repetitions}
    for name, size in _SIZES.items():
        messages = round(duration_s * size.rate_hz)
        with ExitStack() as stack:
            turns = {
                "receiver": stack.enter_context(_receiver(name, size)),
                "endpoint": stack.enter_context(_endpoint(name, size, checkout)),
            }
            for turn in turns.values():
                turn.play(size.rate_hz)  # the first ones are slower, as those of any program
                turn.results.clear()
            for _ in range(repetitions):
                for turn in turns.values():
                    turn.play(messages)
        found |= _summary(name, turns)
    results.parent.mkdir(parents=True, exist_ok=True)
    results.write_text(json.dumps(found, indent=2) + "\n")


def _summary(name: str, turns: dict[str, Turn]) -> dict[str, float]:
    found: dict[str, float] = {}
    for server, turn in turns.items():
        medians = Figures(*np.median(turn.results, axis=0))
        found |= {f"{server}_{name}_{what}": it for what, it in medians._asdict().items()}
    pairs = np.array(turns["receiver"].results) / np.maximum(turns["endpoint"].results, 1e-9)
    latency, _, cpu, _ = np.median(pairs, axis=0)
    found[f"latency_ratio_to_endpoint_{name}"] = float(latency)
    found[f"cpu_ratio_to_endpoint_{name}"] = float(cpu)
    found[f"ratio_to_endpoint_{name}"] = float(max(latency, cpu))
    return found


@contextmanager
def _receiver(name: str, size: _Size) -> Iterator[Turn]:
    topic = f"/bench/receiver_{name}"
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="ml2_downlink")))
        config = folder / "config.yaml"
        parameters = {"battery": {"enabled": True}, "app": {"subscribe": [topic]}}
        config.write_text(yaml.safe_dump({"ml2_receiver": {"ros__parameters": parameters}}))
        command = receive_command(config, "127.0.0.1:0")
        server = stack.enter_context(process(command, dict(os.environ), folder / "log"))
        address = listening_address(server)
        device = stack.enter_context(MockDevice(address, says_ping=True, has_ros=True))
        device.start()
        lane = device.open(Open(1, "subscription", topic, size.type, keep="all", depth=100)).lane
        assert lane is not None
        wire = device.wires["ros"] if lane == "ros" else device.join(lane)
        stream = stack.enter_context(_stream(wire.socket))

        def read() -> bytearray:
            header = Header._make(_HEADER.unpack(stream.read(HEADER_BYTES)))
            message = _filled(stream, header.length)
            if lane != "ros":
                wire.send(Kind.TAKEN, channel=header.channel, sequence=header.sequence)
            return message

        arrivals = Arrivals(_until_end(read), size)
        yield Turn(arrivals, _publisher(stack, topic, size), lambda: _cpu_s(server.pid))


@contextmanager
def _endpoint(name: str, size: _Size, checkout: str) -> Iterator[Turn]:
    topic = f"/bench/endpoint_{name}"
    with ExitStack() as stack:
        server = stack.enter_context(Player("endpoint", checkout))
        connection = stack.enter_context(connect(server.line()))
        connection.sendall(subscription(topic, size.type))
        stream = stack.enter_context(_stream(connection))

        def part() -> bytearray:
            return _filled(stream, int.from_bytes(stream.read(4), "little"))

        def read() -> bytearray:
            while bytes(part()).startswith(b"__"):  # it says who it is first
                part()
            return part()

        arrivals = Arrivals(_until_end(read), size)
        yield Turn(arrivals, _publisher(stack, topic, size), lambda: server.usage(0).cpu_s)


@contextmanager
def _stream(connection: socket.socket) -> Iterator[IO[bytes]]:
    """A stream that another thread reads; its end is before that of the connection."""
    connection.settimeout(None)
    with connection.makefile("rb") as stream:
        try:
            yield stream
        finally:
            connection.shutdown(socket.SHUT_RDWR)


def _publisher(stack: ExitStack, topic: str, size: _Size) -> Player:
    publisher = Player("publisher", topic, str(size.rate_hz), *size.publisher)
    stack.enter_context(publisher).line()
    return publisher


def _filled(stream: IO[bytes], length: int) -> bytearray:
    message = bytearray(length)
    if stream.readinto(message) < length:  # type: ignore[attr-defined]
        raise EOFError
    return message


def _until_end(read: Callable[[], bytearray]) -> Callable[[], bytearray]:
    def read_or_nothing() -> bytearray:
        try:
            return read()
        except (EOFError, OSError, ValueError, struct.error):  # the benchmark ends
            return bytearray()

    return read_or_nothing


def _cpu_s(pid: int) -> float:
    """Returns the CPU time of a process and its children, which it has not waited for."""
    seconds = 0.0
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):  # it has just ended
            continue
        if pid in (int(folder.name), int(fields[1])):
            seconds += (int(fields[11]) + int(fields[12])) / _TICKS_PER_S
    return seconds


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], float(sys.argv[3]), int(sys.argv[4]))
