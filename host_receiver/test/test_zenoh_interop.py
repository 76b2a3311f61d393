"""Another program for rmw_zenoh's conventions, zenoh-ros2-sdk, lists our topics and reads them.

It computes the hashes of types from the .msg files of ROS.
"""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import pytest
import zenoh
from zenoh_ros2_sdk import ROS2Subscriber
from zenoh_ros2_sdk.discovery import get_topic_info, get_topic_names_and_types
from zenoh_ros2_sdk.message_registry import get_registry
from zenoh_ros2_sdk.qos import QosDurability, QosProfile
from zenoh_ros2_sdk.session import ZenohSession

import bag_scene
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.string_message import encode_string
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.sink import ZenohSink
from waiting import LIMIT_S, await_true
from zenoh_peers import free_endpoint, open_router

pytest.importorskip("rclpy", reason="rclpy is not installed")

DOMAIN, PREFIX = 9, "/robot1/magic_leap2"
TABLE = load_table()


def topic(stream: str, role: str, suffix: str = "") -> Topic:
    topics = TABLE.streams[stream].topics
    return next(it for it in topics if it.role == role and it.name.endswith(suffix))


IMAGE = topic("world_left", "image", "image_raw")
METADATA = topic("world_left", "metadata")
IMU = topic("gyro_left", "imu")
STATIC = topic("tf", "tf_static")


@pytest.fixture(scope="module")
def endpoint() -> Iterator[str]:
    endpoint = free_endpoint()
    with open_router(endpoint):
        yield endpoint


@pytest.fixture(scope="module")
def sink(endpoint: str) -> Iterator[ZenohSink]:
    with zenoh.open(session_configuration(endpoint, None)) as session:
        sink = ZenohSink(session, TABLE, PREFIX, "robot1", DOMAIN, lambda: None)
        yield sink
        sink.close()


@pytest.fixture(scope="module", autouse=True)
def theirs(endpoint: str) -> Iterator[dict[str, Any]]:
    """Their session, with ROS's definitions of messages; and where its router is."""
    spec = find_spec("sensor_msgs")
    assert spec is not None
    assert spec.origin is not None
    get_registry(str(Path(spec.origin).parents[4] / "share"))
    host, _, port = endpoint.removeprefix("tcp/").partition(":")
    at: dict[str, Any] = {"domain_id": DOMAIN, "router_ip": host, "router_port": int(port)}
    session = ZenohSession.get_instance(host, int(port))
    yield at
    session.close()


def imu() -> bytes:
    types = bag_scene.TYPES.types
    header = types["std_msgs/msg/Header"](
        stamp=types["builtin_interfaces/msg/Time"](sec=17, nanosec=5), frame_id="gyro_left"
    )
    vector, turn = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    message = types["sensor_msgs/msg/Imu"](
        header=header,
        orientation=turn(x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=np.zeros(9),
        angular_velocity=vector(x=0.25, y=-1.5, z=3.0),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector(x=0.0, y=9.75, z=0.0),
        linear_acceleration_covariance=np.zeros(9),
    )
    return bytes(bag_scene.TYPES.serialize_cdr(message, "sensor_msgs/msg/Imu"))


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
    opened = [IMU, IMAGE, METADATA, STATIC]
    for it in opened:
        sink.open(it)
    expected = {it.full_name(PREFIX): [it.type] for it in opened}
    expected |= {f"{PREFIX}/{it.name}": [it.type] for it in TABLE.receiver_topics}
    expected["/diagnostics"] = ["diagnostic_msgs/msg/DiagnosticArray"]
    await_true(lambda: dict(get_topic_names_and_types(**theirs)) == expected)
    info = get_topic_info(IMU.full_name(PREFIX), verbose=True, **theirs)
    assert info is not None
    (publisher,) = info.publishers
    assert (publisher.node_namespace, publisher.node_name) == ("/robot1", "ml2_receiver")
    assert QosProfile.decode(publisher.qos) == QosProfile(history_depth=200)
