"""Takes large messages of ROS in a process of its own.

rclpy holds the lock of the interpreter while it copies a message: 15 to 43 ms for 16 MiB. In the
process of the receiver that would hold back samples of IMUs.
"""

from __future__ import annotations

import mmap
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import IO, Protocol

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from ..json_text import json_text
from ..session.subscription_queue import Payload
from . import bulk_child
from .bulk_child import HEADER, SMALL_BYTES, STOP_S
from .fastdds import SEGMENT_VARIABLE, SMALL_SEGMENT_BYTES
from .given_arguments import given
from .raw_taker import Taking

_RESTART_S = 1.0


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
        spare: _Process | None = None
        while not self._stopping.is_set():
            began_s = time.monotonic()
            process, spare = spare or _Process(self._node), None
            with self._told(process), suppress(OSError):
                while self._receive(process.messages):
                    spare = spare or _Process(self._node)
            if not self._stopping.wait(max(0.0, began_s + _RESTART_S - time.monotonic())):
                self._node.get_logger().warning("the process that takes large messages has ended")
        if spare is not None:
            spare.end()

    @contextmanager
    def _told(self, process: _Process) -> Iterator[None]:
        """Tells a process what to take, from now on; ends it with the block."""
        with self._lock:
            self._commands = process.commands
            for number, wanted in self._open.items():
                self._tell(_opening(number, wanted))
            if self._stopping.is_set():
                process.commands.close()
        yield
        with self._lock:
            self._commands = None
        process.end()

    def _receive(self, messages: socket.socket) -> bool:
        """Passes on a message; returns False at the end."""
        packet, files, _, _ = socket.recv_fds(messages, HEADER.size + SMALL_BYTES, 1)
        if not packet:
            return False
        number, source_ns, publication, length = HEADER.unpack_from(packet)
        payload: Payload = packet[HEADER.size :]
        for file in files:
            payload = mmap.mmap(file, length, prot=mmap.PROT_READ)
            os.close(file)
        messages.send(b"1")
        with self._lock:
            subscription = self._open.get(number)
        if subscription is not None and length < 0:
            self._failed(subscription.topic, ValueError(bytes(payload).decode(errors="replace")))
        elif subscription is not None:
            subscription.take_plain(payload, source_ns, publication)
        return True


class _Process:
    """A child that joins ROS at once, and subscribes to nothing before its first command.

    Both take seconds on a busy machine, which a spare child has behind it.

    Attributes:
        messages: the messages that it takes.
        commands: a line for each topic; the end of the commands ends the process.
    """

    def __init__(self, main: Node) -> None:
        self.messages, its = socket.socketpair(type=socket.SOCK_SEQPACKET)
        names = (f"{main.get_name()}_bulk", main.get_namespace())
        with its:
            self._process = subprocess.Popen(
                [sys.executable, "-m", bulk_child.__name__, str(its.fileno()), *names, *given()],
                pass_fds=[its.fileno()],
                stdin=subprocess.PIPE,
                text=True,
                env={
                    **os.environ,
                    "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
                    SEGMENT_VARIABLE: str(SMALL_SEGMENT_BYTES),  # it publishes nothing
                },
                start_new_session=True,  # Ctrl-C is for this process, which then ends that one
            )
        assert self._process.stdin is not None
        self.commands = self._process.stdin

    def end(self) -> None:
        with self.messages, self._process, suppress(OSError):  # closing may find the process gone
            self.commands.close()
            try:
                self._process.wait(STOP_S)
            except subprocess.TimeoutExpired:
                self._process.kill()


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
