"""A stand-in for ROS-TCP-Endpoint in tests; tests/bench/endpoint.py describes its wire format.

Invalid data end the connection.
"""

from __future__ import annotations

import json
import socket
import struct
import threading
from collections.abc import Callable
from importlib import import_module
from typing import Any

from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import deserialize_message, serialize_message


class TcpServer(Node):
    """Serves one connection; frames are decoded and published as messages."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        host = self.declare_parameter("ROS_IP", "").value
        port = self.declare_parameter("ROS_TCP_PORT", 0).value
        self._listener = socket.create_server((host, port))
        self._topics: dict[str, tuple[type, Publisher]] = {}

    def start(self) -> None:
        threading.Thread(target=self._serve, daemon=True).start()

    def setup_executor(self) -> None:
        executor = SingleThreadedExecutor()
        executor.add_node(self)
        executor.spin()

    def _serve(self) -> None:
        connection, _ = self._listener.accept()
        with connection, connection.makefile("rb") as stream:
            while True:
                destination, payload = _block(stream.read).decode(), _block(stream.read)
                if destination == "__publish":
                    self._register(**json.loads(payload[:-1].decode()))
                elif destination == "__subscribe":
                    self._subscribe(connection, **json.loads(payload[:-1].decode()))
                else:
                    message, publisher = self._topics[destination]
                    publisher.publish(deserialize_message(payload, message))

    def _subscribe(self, connection: socket.socket, topic: str, message_name: str) -> None:
        def send(message: object) -> None:
            parts = topic.encode(), serialize_message(message)
            connection.sendall(b"".join(struct.pack("<I", len(it)) + it for it in parts))

        self.create_subscription(_message(message_name), topic, send, 10)

    def _register(self, topic: str, message_name: str, queue_size: int, latch: bool) -> None:
        message = _message(message_name)
        assert not latch
        self._topics[topic] = message, self.create_publisher(message, topic, queue_size)


def _message(name: str) -> Any:
    package, _, name = name.partition("/")
    return getattr(import_module(f"{package}.msg"), name)


def _block(read: Callable[[int], bytes]) -> bytes:
    (length,) = struct.unpack("<I", read(4))
    data = read(length)
    assert len(data) == length
    return data
