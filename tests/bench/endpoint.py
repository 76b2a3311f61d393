"""Starts Unity's ROS-TCP-Endpoint from a checkout of the user, and encodes messages to it.

A message is a destination and a payload, each preceded by its length as u32 LE. A message to the
destination __publish or __subscribe registers a topic; its payload is JSON and one extra byte. The
topic's name is a destination afterwards.
"""

import json
import socket
import struct
import sys
import threading
import time
from pathlib import Path

_LENGTH = struct.Struct("<I")
_TIMEOUT_S = 10.0
_POLL_S = 0.05


def message(destination: str, payload: bytes) -> bytes:
    name = destination.encode()
    return _LENGTH.pack(len(name)) + name + _LENGTH.pack(len(payload)) + payload


def registration(topic: str, type: str, queue_size: int) -> bytes:
    """Returns the message that registers a publisher; `type` is as in the stream table."""
    publisher = {
        "topic": topic,
        "message_name": type.replace("/msg/", "/"),
        "queue_size": queue_size,
        "latch": False,
    }
    return message("__publish", json.dumps(publisher).encode() + b"\0")


def subscription(topic: str, type: str) -> bytes:
    """Returns the message that registers a subscriber; `type` is as in the stream table."""
    subscriber = {"topic": topic, "message_name": type.replace("/msg/", "/")}
    return message("__subscribe", json.dumps(subscriber).encode() + b"\0")


def connect(address: str) -> socket.socket:
    """Connects to an endpoint, and retries while it is starting."""
    host, _, port = address.rpartition(":")
    deadline_s = time.monotonic() + _TIMEOUT_S
    while True:
        try:
            return socket.create_connection((host, int(port)))
        except ConnectionRefusedError:
            if time.monotonic() > deadline_s:
                raise
            time.sleep(_POLL_S)


def start_endpoint(checkout: Path) -> str:
    """Runs the endpoint in threads of this process; returns the address that it will listen on."""
    import rclpy

    sys.path.insert(0, str(checkout))
    from ros_tcp_endpoint import TcpServer  # type: ignore[import-not-found]

    with socket.create_server(("127.0.0.1", 0)) as free:
        host, port = free.getsockname()
    parameters = ("-p", f"ROS_IP:={host}", "-p", f"ROS_TCP_PORT:={port}")
    rclpy.init(args=["endpoint", "--ros-args", *parameters])
    server = TcpServer("endpoint")
    server.start()
    threading.Thread(target=server.setup_executor, daemon=True).start()
    return f"{host}:{port}"
