"""The process that takes large messages of ROS, and hands them to bulk_process.

The commands are lines of JSON on standard input: what to subscribe to, by number. A message is a
packet of a socket: HEADER, and its bytes, which are in a file in memory if they are more than
SMALL_BYTES. The receiver answers each packet with one byte.
"""

from __future__ import annotations

import itertools
import json
import os
import socket
import struct
import sys
import threading
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from .context import end_node, start_node
from .layout import described, plain
from .raw_taker import RawTaker

# Number of the subscription, source time in ns, number of the publication, length. A length below 0
# is that of the reason why the subscription has failed.
HEADER = struct.Struct("<Iqqq")
SMALL_BYTES = 64 << 10
STOP_S = 2.0
_NICENESS = 10
# Messages that the receiver has not got yet stay in ROS's queues beyond so many.
_MOST_UNANSWERED = 4


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
        self._unanswered = 0
        self._open: dict[int, _Sending] = {}
        self._taker = RawTaker(node, [], self._fail)

    def run(self, commands: Iterable[str]) -> None:
        for line in commands:
            self._obey(json.loads(line))
        end = threading.Timer(STOP_S, os._exit, [1])
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
        header = HEADER.pack(number, source_ns, publication, len(payload))
        if len(payload) <= SMALL_BYTES:
            self._write(header + payload, [])
            return
        # Its pages become those of the receiver, without a copy
        file = os.memfd_create("message")
        try:
            written = os.write(file, payload)
            assert written == len(payload)
            self._write(header, [file])
        finally:
            os.close(file)

    def _fail(self, topic: str, error: Exception) -> None:
        reason = str(error).encode()[:SMALL_BYTES]
        for number in [number for number, it in list(self._open.items()) if it.topic == topic]:
            self._write(HEADER.pack(number, 0, 0, -len(reason)) + reason, [])

    def _write(self, packet: bytes, files: list[int]) -> None:
        with self._sending, suppress(OSError):  # the end, which the input has, too
            while self._unanswered >= _MOST_UNANSWERED:
                self._messages.recv(1)
                self._unanswered -= 1
            socket.send_fds(self._messages, [packet], files)
            self._unanswered += 1


def _main(descriptor: str, name: str, namespace: str, *arguments: str) -> None:
    os.nice(_NICENESS)  # large messages give way to samples
    messages = socket.socket(fileno=int(descriptor))

    def make(name: str, context: Context) -> Node:
        return rclpy.create_node(
            name,
            namespace=namespace,
            context=context,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
        )

    # The node's middleware gets to know the others; its name hides it from lists of nodes.
    spare = start_node(lambda context: make(f"_{name}_spare", context), arguments)
    first = sys.stdin.readline()
    if first:
        node = make(name, spare.context)
        _Child(messages, node).run(itertools.chain([first], sys.stdin))
        node.destroy_node()
    end_node(spare)


if __name__ == "__main__":
    _main(*sys.argv[1:])
