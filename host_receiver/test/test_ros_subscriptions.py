"""From publishers of ROS to a scripted device, over a receiver in a process of its own."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from configurations import only
from mock_device import MockDevice
from ros_messages import string
from ros_processes import Receiver
from waiting import await_true

pytest.importorskip("rclpy", reason="rclpy is not installed")

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from ml2_receiver.ros.context import tool_node
from ml2_receiver.wire.opening_bodies import Open

CONFIG = only("battery: {enabled: true}, app: {subscribe: ['/**']}")
STRING = "std_msgs/msg/String"
RELIABLE = QoSProfile(depth=100)
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


@pytest.fixture
def app(receiver: Receiver) -> Iterator[MockDevice]:
    with MockDevice(receiver.address, says_ping=True, has_ros=True) as app:
        app.start()
        yield app


@pytest.fixture
def node(ros_of_children: None) -> Iterator[Node]:
    with tool_node("robot") as node:
        yield node


def subscription(id: int, name: str, type: str = STRING, **more: object) -> Open:
    return Open(id, "subscription", name, type, **more)  # type: ignore[arg-type]


def await_subscriber(publisher: Publisher, count: int = 1) -> None:
    await_true(lambda: publisher.get_subscription_count() == count)


def test_a_message_arrives_as_it_was_published(app: MockDevice, node: Node) -> None:
    assert app.welcome.ros is not None
    assert app.welcome.ros.subscribe
    assert not app.welcome.ros.call
    opened = app.open(subscription(7, "/robot/said"))
    assert (opened.result, opened.name, opened.lane) == ("opened", "/robot/said", "ros")
    publisher = node.create_publisher(String, "/robot/said", RELIABLE)
    await_subscriber(publisher)
    publisher.publish(String(data="hello"))
    header, payload = app.message()
    assert payload.startswith(string("hello"))
    assert (header.channel, header.sequence) == (7, 0)
    assert header.capture_ns <= header.send_ns
