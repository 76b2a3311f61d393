"""Topics of ROS reach the headset's app with the values that were published, and over link cuts."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
import math
import os
import random
import re
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from subprocess import Popen
from typing import NamedTuple

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String, UInt8MultiArray
from tf2_msgs.msg import TFMessage

from configurations import only
from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from processes import (
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
)
from proxy import Proxy
from test_ros_subscriptions import book
from waiting import LIMIT_S, await_true

CONFIG = only(
    "app: {subscribe: [/chatter, /joint_states, /map, /cloud, /tf]}, other_sensors: {enabled: true}"
)
STRING, JOINTS = "std_msgs/msg/String", "sensor_msgs/msg/JointState"
BYTES = "std_msgs/msg/UInt8MultiArray"
# A layout without dimensions and offset, then the bytes
HEAD = bytes((0, 1, 0, 0)) + bytes(8)
MOST_BYTES = (16 << 20) - len(HEAD) - 4
KEPT = QoSProfile(depth=200)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
CHILD = {"map": "odom", "odom": "base_link"}
TEXTS = ["", "Größe 頭", '"\\\n', "x" * 400, *map(str, range(16))]
# 200 take three and a half minutes, since the headset tries less and less often.
CUTS = int(os.environ.get("ML2S_CUTS", "5"))
_LINE = re.compile(r"(/\w+) (\d+) (\d+) (.*)\n")


class Printed(NamedTuple):
    """A message as the headset prints it."""

    topic: str
    number: int
    published_ns: int
    text: str


def printed(headset: Popen[str]) -> Iterator[Printed]:
    for line in lines(headset):
        if (found := _LINE.fullmatch(line)) is not None:
            topic, number, published_ns, text = found.groups()
            yield Printed(topic, int(number), int(published_ns), text)


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Iterator[Node]:
    for name, value in isolated_environment().items():
        monkeypatch.setenv(name, value)
    with tool_node("robot") as node:
        yield node


@pytest.fixture
def address(node: Node, tmp_path: Path) -> Iterator[str]:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG)
    command = receive_command(config, "127.0.0.1:0")
    with process(command, dict(os.environ), tmp_path / "receiver.log") as receiver:
        yield listening_address(receiver)


def is_heard_reliably(node: Node, publisher: Publisher) -> bool:
    """True when the receiver has seen that a publisher is reliable, and subscribed so."""
    found = node.get_subscriptions_info_by_topic(publisher.topic_name)
    is_reliable = all(it.qos_profile.reliability == ReliabilityPolicy.RELIABLE for it in found)
    return bool(found and is_reliable and publisher.get_subscription_count())


def settled(node: Node, topic: str) -> dict[str, int]:
    """Returns the counts of both sides as soon as the app has taken all that was sent."""
    while True:
        counts = book(node, topic)
        arrived, taken = counts.get("app.received"), counts.get("app.taken")
        if not counts["waiting"] and counts["sent"] == arrived == taken:
            return counts


def subscribing(
    address: str, folder: Path, *topics: tuple[str, str]
) -> contextlib.AbstractContextManager[Popen[str]]:
    """Runs a headset that prints topics, each given with its type."""
    words = [word for topic in topics for word in ("--subscribe", *topic)]
    return process(headset_command(address, *words), dict(os.environ), folder / "headset.log")


def test_values_times_and_numbers_are_those_that_were_published(
    node: Node, address: str, tmp_path: Path
) -> None:
    chatter = node.create_publisher(String, "/chatter", KEPT)
    joints = node.create_publisher(JointState, "/joint_states", KEPT)
    states = [
        JointState(name=["a", "bc"][:count], position=[0.1] * count, effort=[-1e300] * (count % 2))
        for count in range(20)
    ]
    wanted = ("/chatter", STRING), ("/joint_states", JOINTS), ("/secret", STRING)
    with subscribing(address, tmp_path, *wanted) as headset:
        await_true(lambda: all(is_heard_reliably(node, it) for it in (chatter, joints)))
        began_ns = time.time_ns()
        for text, state in zip(TEXTS, states, strict=True):
            chatter.publish(String(data=text))
            joints.publish(state)
        messages = printed(headset)
        got = [next(messages) for _ in range(len(TEXTS) + len(states))]
        ended_ns = time.time_ns()
        headset.terminate()
        rest = headset.communicate()[0]
    of_chatter = [it for it in got if it.topic == "/chatter"]
    of_joints = [it for it in got if it.topic == "/joint_states"]
    assert [json.loads(it.text) for it in of_chatter] == [{"data": text} for text in TEXTS]
    assert [deserialize_message(bytes.fromhex(it.text), JointState) for it in of_joints] == states
    for topic in (of_chatter, of_joints):
        assert [it.number for it in topic] == list(range(20))
        times_ns = [began_ns, *(it.published_ns for it in topic), ended_ns]
        assert times_ns == sorted(times_ns)
    assert "/chatter: 20 messages" in rest
    assert "/joint_states: 20 messages" in rest


def test_large_messages_are_those_that_were_published_beside_sensors(
    node: Node, address: str, tmp_path: Path
) -> None:
    cloud = node.create_publisher(UInt8MultiArray, "/cloud", KEPT)
    sample = threading.Semaphore(0)
    imu = RawSubscription(
        "sensor_msgs/msg/Imu",
        "/magic_leap2/accel_left/imu",
        qos_profile_sensor_data,
        lambda _: sample.release(),
    )
    with ExitStack() as stack:
        headset = stack.enter_context(subscribing(address, tmp_path, ("/cloud", BYTES)))
        taker = RawTaker(stack.enter_context(tool_node("imu")), [imu], lambda _, error: None)
        stack.callback(taker.stop)
        await_true(lambda: is_heard_reliably(node, cloud))
        messages = printed(headset)
        for number, size in enumerate((1_000_000, 4, MOST_BYTES, 1_000_000, MOST_BYTES)):
            data = random.Random(number).randbytes(size)
            cloud.publish(UInt8MultiArray(data=data))
            got = next(messages)
            payload = HEAD + struct.pack("<I", size) + data
            text = f"of {len(payload)} bytes, SHA-256 {hashlib.sha256(payload).hexdigest()}"
            assert (got.number, got.text) == (number, text if size > 500 else payload.hex())
            assert sample.acquire(timeout=LIMIT_S)


def moved(parent: str, child: str, second: int, x: float) -> TFMessage:
    """Returns the transform of a second, turned a quarter to the left."""
    made = TransformStamped(child_frame_id=child)
    made.header = Header(stamp=Time(sec=second), frame_id=parent)
    made.transform.translation.x = float(x)  # rclpy reads an int as the bits of a float
    made.transform.rotation.z = made.transform.rotation.w = math.sqrt(0.5)
    return TFMessage(transforms=[made])


def test_a_pose_has_the_stamp_of_the_oldest_transform_and_a_stale_one_stays_at_its_last(
    node: Node, address: str, tmp_path: Path
) -> None:
    publisher = node.create_publisher(TFMessage, "/tf", KEPT)
    command = headset_command(address, "--transform", "base_link", "map")
    poses: list[list[float]] = []
    with process(command, dict(os.environ), tmp_path / "headset.log") as headset:
        await_true(lambda: is_heard_reliably(node, publisher))
        # Nothing is known of map before its second 1, nor after it until its second 4
        for parent, second, x in [("odom", 1, 1), ("map", 1, 10)]:
            publisher.publish(moved(parent, CHILD[parent], second, x))
        for line in lines(headset):
            if (found := line.removeprefix("base_link in map ")) == line:
                continue
            poses.append([float(it) for it in found.split()])
            if len(poses) == 2:
                break
            for parent, second, x in [("odom", 2, 3), ("odom", 4, 7), ("map", 4, 40)]:
                publisher.publish(moved(parent, CHILD[parent], second, x))
        headset.terminate()
        rest = headset.communicate()[0]
    # A quarter turn in map takes x of odom to y, and two of them are a half
    expected = [[at * 1e9, at * 1e9, x, y, 0, 0, 0, 1, 0] for at, x, y in [(1, 10, 1), (4, 40, 7)]]
    assert poses == [pytest.approx(it, abs=1e-12) for it in expected]
    assert "base_link in map: 2 messages" in rest


def test_a_refused_topic_says_why_and_the_others_go_on(
    node: Node, address: str, tmp_path: Path
) -> None:
    latched = node.create_publisher(String, "/map", LATCHED)
    latched.publish(String(data="map"))
    wanted = ("/secret", STRING), ("/chatter", "absent_msgs/msg/Absent"), ("/map", STRING)
    refused: dict[str, str] = {}
    is_heard = False
    with subscribing(address, tmp_path, *wanted) as headset:
        while len(refused) < len(wanted) - 1 or not is_heard:
            line = next(lines(headset))
            if line.startswith("not subscribed: "):
                _, topic, reason = line.split(": ", 2)
                refused[topic] = reason
            is_heard |= line.startswith("/map 0 ")
    assert refused["/secret"] == "no rule in app.subscribe has /secret\n"
    assert "absent_msgs" in refused["/chatter"]


def test_over_link_cuts_nothing_comes_twice_latched_messages_come_again_and_books_balance(
    node: Node, address: str, tmp_path: Path
) -> None:
    latched = node.create_publisher(String, "/map", LATCHED)
    latched.publish(String(data="map"))
    counting = node.create_publisher(String, "/chatter", KEPT)
    next_number = itertools.count()
    got: list[Printed] = []
    wanted = ("/chatter", STRING), ("/map", STRING)
    with Proxy(address) as proxy, subscribing(proxy.address, tmp_path, *wanted) as headset:
        messages = printed(headset)
        for cut in range(CUTS + 1):
            while sum(it.topic == "/map" for it in got) <= cut:
                got.append(next(messages))
            await_true(lambda: counting.get_subscription_count() > 0)
            for _ in range(random.randrange(100)):
                counting.publish(String(data=str(next(next_number))))
            if cut < CUTS:
                proxy.cut()
        counts = settled(node, "/chatter")
        headset.terminate()
        rest = headset.communicate()[0]
    got.extend(Printed(t, int(n), int(p), x) for t, n, p, x in _LINE.findall(rest))
    for topic in ("/chatter", "/map"):
        numbers = [it.number for it in got if it.topic == topic]
        assert numbers == sorted(set(numbers))
        assert f"{topic}: {len(numbers)} messages" in rest
    counted = [int(json.loads(it.text)["data"]) for it in got if it.topic == "/chatter"]
    assert counted == sorted(set(counted))
    assert counts["app.taken"] == len(counted)
    assert {it.text for it in got if it.topic == "/map"} == {'{"data":"map"}'}
