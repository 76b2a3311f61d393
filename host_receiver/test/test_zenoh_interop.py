"""Another program for rmw_zenoh's conventions, zenoh-ros2-sdk, lists our topics and reads them.

It computes the hashes of types from the .msg files of ROS.
"""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest
from zenoh_ros2_sdk import ROS2Subscriber
from zenoh_ros2_sdk.discovery import get_topic_info, get_topic_names_and_types
from zenoh_ros2_sdk.message_registry import get_registry
from zenoh_ros2_sdk.qos import QosDurability, QosProfile
from zenoh_ros2_sdk.session import ZenohSession

import bag_scene
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.plain_messages import encode_string
from ml2_receiver.zenoh.sink import ZenohSink
from waiting import LIMIT_S, await_true
from zenoh_scene import DOMAIN, IMAGE, IMU, METADATA, PREFIX, STATIC, imu, open_topics, routed_sink

pytest.importorskip("rclpy", reason="rclpy is not installed")


@pytest.fixture(scope="module")
def site() -> Iterator[tuple[str, ZenohSink]]:
    with routed_sink() as site:
        yield site


@pytest.fixture
def sink(site: tuple[str, ZenohSink]) -> ZenohSink:
    return site[1]


@pytest.fixture(scope="module", autouse=True)
def theirs(site: tuple[str, ZenohSink]) -> Iterator[dict[str, Any]]:
    """Their session, with ROS's definitions of messages; and where its router is."""
    spec = find_spec("sensor_msgs")
    assert spec is not None
    assert spec.origin is not None
    get_registry(str(Path(spec.origin).parents[4] / "share"))
    host, _, port = site[0].removeprefix("tcp/").partition(":")
    at: dict[str, Any] = {"domain_id": DOMAIN, "router_ip": host, "router_port": int(port)}
    session = ZenohSession.get_instance(host, int(port))
    yield at
    session.close()


def read(sink: ZenohSink, topic: Topic, payload: bytes, theirs: dict[str, Any]) -> Any:
    """Returns the message that zenoh-ros2-sdk reads from a payload that we publish."""
    messages: SimpleQueue[Any] = SimpleQueue()
    publish = sink.open(topic)
    name = topic.full_name(PREFIX)
    subscriber = ROS2Subscriber(name, topic.type, messages.put, **theirs)
    await_true(lambda: sink.demand()[topic.stream])
    publish(bytearray(payload))
    message = messages.get(timeout=LIMIT_S)
    subscriber.close()
    await_true(lambda: not sink.demand()[topic.stream])
    return message


def test_they_read_an_imu_sample(sink: ZenohSink, theirs: dict[str, Any]) -> None:
    message = read(sink, IMU, imu(), theirs)
    assert (message.header.stamp.sec, message.header.frame_id) == (17, "gyro_left")
    assert (message.angular_velocity.y, message.linear_acceleration.y) == (-1.5, 9.75)


def test_they_read_an_image(sink: ZenohSink, theirs: dict[str, Any]) -> None:
    message = read(sink, IMAGE, bag_scene.image(3), theirs)
    pixels = bag_scene.pixels(3)
    assert (message.height, message.width) == pixels.shape
    assert message.data.tobytes() == pixels.tobytes()


def test_they_read_a_string(sink: ZenohSink, theirs: dict[str, Any]) -> None:
    message = read(sink, METADATA, encode_string('{"exposure_ms": 3}'), theirs)
    assert message.data == '{"exposure_ms": 3}'


def test_they_read_what_was_latched_before_they_came(
    sink: ZenohSink, theirs: dict[str, Any]
) -> None:
    sink.open(STATIC)(bytearray(bag_scene.tf(0)))
    messages: SimpleQueue[Any] = SimpleQueue()
    qos = QosProfile(durability=QosDurability.TRANSIENT_LOCAL, history_depth=1)
    subscriber = ROS2Subscriber(STATIC.name, STATIC.type, messages.put, qos=qos, **theirs)
    assert messages.get(timeout=LIMIT_S).transforms
    subscriber.close()


def test_they_list_our_topics_with_types_and_qos(sink: ZenohSink, theirs: dict[str, Any]) -> None:
    expected = {name: [type] for name, type in open_topics(sink).items()}
    await_true(lambda: dict(get_topic_names_and_types(**theirs)) == expected)
    info = get_topic_info(IMU.full_name(PREFIX), verbose=True, **theirs)
    assert info is not None
    (publisher,) = info.publishers
    assert (publisher.node_namespace, publisher.node_name) == ("/robot1", "ml2_receiver")
    assert QosProfile.decode(publisher.qos) == QosProfile(history_depth=200)
