"""An independent subscriber for tests: writes what it sees of one topic as JSON lines.

First the publishers' type and QoS, once there is one; then each message's bytes in hexadecimal.
"""

import contextlib
import json
import os
import signal
import sys
from importlib import import_module
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ml2_receiver.ros.fastdds import apply_default_profile

_WAIT_S = 0.1


def main(topic: str, type: str, durability: str) -> None:
    package, _, name = type.partition("/msg/")
    # A shell may have started the tests to ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # So that Fast DDS writes no log among the lines
    apply_default_profile(os.environ, sends_images=False)
    rclpy.init()
    node = rclpy.create_node("subscriber")
    while not say_publishers(node, topic):
        rclpy.spin_once(node, timeout_sec=_WAIT_S)
    qos = QoSProfile(
        depth=1000,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy[durability.upper()],
    )
    message = getattr(import_module(f"{package}.msg"), name)
    node.create_subscription(message, topic, say_payload, qos, raw=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


def say_publishers(node: Node, topic: str) -> bool:
    publishers = node.get_publishers_info_by_topic(topic)
    for publisher in publishers:
        qos = publisher.qos_profile
        say(
            {
                "type": publisher.topic_type,
                "reliability": qos.reliability.name,
                "durability": qos.durability.name,
            }
        )
    return bool(publishers)


def say_payload(payload: Any) -> None:
    say(payload.hex())


def say(line: object) -> None:
    print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
