"""Takes large messages of ROS in a process of its own.

rclpy holds the lock of the interpreter while it copies a message: 15 to 43 ms for 16 MiB. In the
process of the receiver that would hold back samples of IMUs. It reads the same bytes from a socket
without the lock.
"""

from __future__ import annotations

import json
import mmap
import os
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import IO, Any, Protocol

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ..json_text import json_text
from ..session.subscription_queue import Payload
from .context import start_node
from .given_arguments import given
from .layout import described, plain
from .raw_taker import RawTaker, Taking

# Number of the subscription, source time in ns, number of the publication, length. A length below 0
# is that of the reason why the subscription has failed.
_HEADER = struct.Struct("<Iqqq")
# What is longer gets memory that costs nothing before its bytes arrive.
_SMALL_BYTES = 64 << 10
_RESTART_S = 1.0
_STOP_S = 2.0


class TakingPlain(Taking, Protocol):
    """A subscription that gets plain CDR of another process."""

    def take_plain(self, payload: Payload, source_ns: int, number: int) -> None: ...


class BulkTaker:
    """A RawTaker in a child process, which is started again when it ends. Thread-safe.

    It ends with this process, however this one ends.

    Args:
        node: the child's node has its name with `_bulk` behind it.
        failed: gets the topics that cannot be read.
    """

    def __init__(self, node: Node, failed: Callable[[str, Exception], None]) -> None:
        self._node, self._failed = node, failed
        self._lock = threading.Lock()
        self._open: dict[int, TakingPlain] = {}
        self._last = 0
        self._commands: IO[str] | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="bulk-taker", daemon=True)
        self._thread.start()

    def add(self, wanted: TakingPlain) -> None:
        """Subscribes to one more topic, soon."""
        with self._lock:
            self._last += 1
            self._open[self._last] = wanted
            self._tell(_opening(self._last, wanted))

    def remove(self, subscription: TakingPlain) -> None:
        """Ends a subscription that was added, soon."""
        with self._lock:
            for number in self._numbers(subscription):
                del self._open[number]
                self._tell({"number": number})

    def replace(self, old: TakingPlain, new: TakingPlain) -> None:
        """Ends a subscription once another one has taken its place."""
        with self._lock:
            for number in self._numbers(old):
                self._open[number] = new
                self._tell(_opening(number, new))

    def _numbers(self, subscription: TakingPlain) -> list[int]:
        return [number for number, it in self._open.items() if it is subscription]

    def _tell(self, command: Mapping[str, object]) -> None:
        if self._commands is not None:
            with suppress(OSError):  # the next process is told everything
                print(json_text(command), file=self._commands, flush=True)

    def stop(self) -> None:
        """Ends the process."""
        self._stopping.set()
        with self._lock:
            if self._commands is not None:
                with suppress(OSError):  # the process has just ended
                    self._commands.close()
                self._commands = None
        self._thread.join()

    def _run(self) -> None:
        while not self._stopping.is_set():
            began_s = time.monotonic()
            with self._process() as messages, suppress(OSError):
                while self._receive(messages):
                    pass
            if not self._stopping.wait(max(0.0, began_s + _RESTART_S - time.monotonic())):
                self._node.get_logger().warning("the process that takes large messages has ended")

    @contextmanager
    def _process(self) -> Iterator[socket.socket]:
        main = self._node
        names = (f"{main.get_name()}_bulk", main.get_namespace())
        own, its = socket.socketpair()
        with (
            own,
            subprocess.Popen(
                [sys.executable, "-m", __name__, str(its.fileno()), *names, *given()],
                pass_fds=[its.fileno()],
                stdin=subprocess.PIPE,
                text=True,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
                start_new_session=True,  # Ctrl-C is for this process, which then ends that one
            ) as process,
        ):
            its.close()
            with self._lock:
                self._commands = process.stdin
                for number, wanted in self._open.items():
                    self._tell(_opening(number, wanted))
                if self._stopping.is_set() and process.stdin is not None:
                    process.stdin.close()
            yield own
            with self._lock:
                self._commands = None
            _end(process)

    def _receive(self, messages: socket.socket) -> bool:
        """Passes on a message; returns False at the end."""
        header = bytearray(_HEADER.size)
        if not _fill(messages, header):
            return False
        number, source_ns, publication, length = _HEADER.unpack(header)
        size = abs(length)
        payload = mmap.mmap(-1, size) if size > _SMALL_BYTES else bytearray(size)
        if not _fill(messages, payload):
            return False
        with self._lock:
            subscription = self._open.get(number)
        if subscription is not None and length < 0:
            self._failed(subscription.topic, ValueError(bytes(payload).decode()))
        elif subscription is not None:
            subscription.take_plain(payload, source_ns, publication)
        return True


def _opening(number: int, wanted: TakingPlain) -> dict[str, object]:
    qos = wanted.qos
    return {
        "number": number,
        "type": wanted.type,
        "topic": wanted.topic,
        "depth": qos.depth,
        "is_reliable": qos.reliability == ReliabilityPolicy.RELIABLE,
        "is_latched": qos.durability == DurabilityPolicy.TRANSIENT_LOCAL,
    }


def _fill(messages: socket.socket, target: bytearray | mmap.mmap) -> bool:
    return messages.recv_into(target, 0, socket.MSG_WAITALL) == len(target)


def _end(process: subprocess.Popen[str]) -> None:
    """Ends the process, which has ended its output or got the end of its input."""
    if process.stdin is not None:
        with suppress(OSError):
            process.stdin.close()
    try:
        process.wait(_STOP_S)
    except subprocess.TimeoutExpired:
        process.kill()


@dataclass(frozen=True)
class _Sending:
    """A subscription of the child, which sends what it takes."""

    number: int
    type: str
    topic: str
    qos: QoSProfile
    send: Callable[[int, int, int, bytes], None]

    def take(self, payload: bytes, info: Mapping[str, int]) -> None:
        times = info["source_timestamp"], info["publication_sequence_number"]
        self.send(self.number, *times, plain(payload, described(self.type).layout))


class _Child:
    """The child: takes what the lines of its input say, until that ends."""

    def __init__(self, messages: socket.socket, node: Node) -> None:
        self._messages = messages
        self._sending = threading.Lock()
        self._open: dict[int, _Sending] = {}
        self._taker = RawTaker(node, [], self._fail)

    def run(self, commands: IO[str]) -> None:
        for line in commands:
            self._obey(json.loads(line))
        end = threading.Timer(_STOP_S, os._exit, [1])
        end.daemon = True
        end.start()
        with suppress(OSError):  # the parent may be gone
            self._messages.shutdown(socket.SHUT_RDWR)
        self._taker.stop()

    def _obey(self, command: dict[str, Any]) -> None:
        number = command["number"]
        old = self._open.pop(number, None)
        if "topic" not in command:
            if old is not None:
                self._taker.remove(old)
            return
        reliability, durability = ReliabilityPolicy, DurabilityPolicy
        qos = QoSProfile(
            depth=command["depth"],
            reliability=reliability.RELIABLE if command["is_reliable"] else reliability.BEST_EFFORT,
            durability=durability.TRANSIENT_LOCAL if command["is_latched"] else durability.VOLATILE,
        )
        new = _Sending(number, command["type"], command["topic"], qos, self._send)
        self._open[number] = new
        if old is None:
            self._taker.add(new)
        else:
            self._taker.replace(old, new)

    def _send(self, number: int, source_ns: int, publication: int, payload: bytes) -> None:
        self._write(_HEADER.pack(number, source_ns, publication, len(payload)), payload)

    def _fail(self, topic: str, error: Exception) -> None:
        reason = str(error).encode()
        for number in [number for number, it in list(self._open.items()) if it.topic == topic]:
            self._write(_HEADER.pack(number, 0, 0, -len(reason)), reason)

    def _write(self, header: bytes, body: bytes) -> None:
        with self._sending, suppress(OSError):  # the end, which the input has, too
            self._messages.sendall(header)
            self._messages.sendall(body)


def _main(descriptor: str, name: str, namespace: str, *arguments: str) -> None:
    messages = socket.socket(fileno=int(descriptor))
    node = start_node(
        lambda context: rclpy.create_node(
            name,
            namespace=namespace,
            context=context,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
        ),
        arguments,
    )
    _Child(messages, node).run(sys.stdin)
    node.destroy_node()
    rclpy.shutdown(context=node.context)


if __name__ == "__main__":
    _main(*sys.argv[1:])
