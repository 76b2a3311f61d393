"""Services and transforms of ROS for a scripted device, over a receiver in its own process."""

import random
import struct
import threading
import time
from bisect import bisect_left
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any, NamedTuple

import numpy as np
import pytest
from pytransform3d.rotations import quaternion_slerp
from pytransform3d.transform_manager import TransformManager
from pytransform3d.transformations import transform_from_pq
from scipy.spatial.transform import Rotation

from configurations import only
from mock_device import MockDevice

pytest.importorskip("rclpy", reason="rclpy is not installed")

from geometry_msgs.msg import TransformStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from rclpy.time import Time
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage

from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.layout import described_service
from ml2_receiver.topics.transform_buffer import Rigid, TransformBuffer, TransformError
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, Header
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.opening_bodies import Close, Failure, Open, Pose
from waiting import LIMIT_S, await_true

CONFIG = only("battery: {enabled: true}, app: {call: ['/**'], subscribe: [/tf]}")
SET_BOOL = "std_srvs/srv/SetBool"
TRUE, EMPTY = CDR_ENCAPSULATION + b"\1", CDR_ENCAPSULATION + b"\0"
SECOND_NS = 1_000_000_000
LONG_NS = int(LIMIT_S) * SECOND_NS
NOTHING = Rigid()
ROTATIONS = Rotation.random(10_000, random_state=1).as_quat().tolist()


@pytest.fixture
def node(ros_of_children: None) -> Iterator[Node]:
    with tool_node("robot") as node:
        yield node


@contextmanager
def answering(node: Node) -> Iterator[None]:
    """Lets the services of a node answer meanwhile."""
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin)
    thread.start()
    try:
        yield
    finally:
        executor.shutdown()
        thread.join()


def client(id: int, name: str, type: str = SET_BOOL, **more: Any) -> Open:
    return Open(id, "client", name, type, **more)


def ask(
    app: MockDevice, number: int, payload: bytes = TRUE, limit_ns: int = LONG_NS, id: int = 1
) -> None:
    header = {"channel": id, "sequence": number, "capture_ns": limit_ns}
    app.wires["ros"].send(Kind.REQUEST, payload, **header)


def answer(app: MockDevice) -> tuple[Header, bytes]:
    frame = app.wires["ros"].receive(time.monotonic() + LIMIT_S)
    assert frame is not None
    return frame.header, bytes(frame.body)


def failure(app: MockDevice) -> tuple[int, str]:
    """The number of the request that the next frame answers, and the code of its failure."""
    header, body = answer(app)
    assert header.kind == Kind.FAILURE, body
    return header.sequence, Failure.parse(body).code


def await_there(
    app: MockDevice, payload: bytes = TRUE, id: int = 1, code: str | None = None
) -> int:
    """Asks until an answer has come, or a failure of this code; returns the number that follows.

    A service whose node is not spun is known with "timeout". One that is spun answers once its
    reader and writer both know those of the client; an answer that is earlier is lost.
    """
    for number in count():
        ask(app, number, payload, SECOND_NS // 10, id)
        header, body = answer(app)
        if header.kind == Kind.RESPONSE or Failure.parse(body).code == code:
            return number + 1
    raise AssertionError


def offer(node: Node, name: str, answer: Callable[[Any, Any], Any], type: Any = SetBool) -> None:
    # With room for all that are under way: by default ROS keeps ten requests that wait.
    node.create_service(type, name, answer, qos_profile=QoSProfile(depth=100))


def response(success: bool, message: str) -> bytes:
    """A response of SetBool or Trigger, with zeros where it has padding."""
    text = message.encode() + b"\0"
    return CDR_ENCAPSULATION + struct.pack("<?3xI", success, len(text)) + text


def echo(request: Any, answer: Any) -> Any:
    answer.success, answer.message = request.data, f"it is {request.data}"
    return answer


def test_a_request_is_answered_by_the_service(app: MockDevice, node: Node) -> None:
    assert app.welcome.ros is not None
    assert app.welcome.ros.call
    offer(node, "/robot/pause", echo)
    opened = app.open(client(7, "/robot/pause", layout="b>bs"))
    assert (opened.result, opened.lane, opened.checked) == ("opened", "ros", "layout")
    with answering(node):
        first = await_there(app, id=7)
        for number, value in ((first + 5, True), (first + 9, False)):
            ask(app, number, CDR_ENCAPSULATION + bytes([value]), id=7)
            header, body = answer(app)
            assert (header.kind, header.channel, header.sequence) == (Kind.RESPONSE, 7, number)
            assert body == response(value, f"it is {value}")


def test_an_answer_has_no_byte_that_its_service_did_not_set(app: MockDevice, node: Node) -> None:
    text = ""

    def say(_: Any, answer: Any) -> Any:
        answer.success, answer.message = True, text
        return answer

    offer(node, "/say", say, Trigger)
    app.open(client(1, "/say", "std_srvs/srv/Trigger", layout="1>bs"))
    with answering(node):
        first = await_there(app, EMPTY)
        for length in range(40):
            text = "x" * length
            ask(app, first + length, EMPTY)
            assert answer(app)[1] == response(True, text)


def test_what_nobody_offers_is_unavailable_and_what_nobody_answers_times_out(
    app: MockDevice, node: Node
) -> None:
    offer(node, "/silent", echo)  # the node is not spun
    app.open(client(1, "/absent"))
    app.open(client(2, "/silent"))
    for number, limit_ns in enumerate((LONG_NS, SECOND_NS // 10)):
        ask(app, number, limit_ns=limit_ns)
        assert failure(app) == (number, "unavailable")
    with answering(node):
        number = await_there(app, id=2)
    ask(app, number, limit_ns=SECOND_NS // 10, id=2)
    assert failure(app) == (number, "timeout")
    with answering(node):  # whose late answers nobody gets
        ask(app, number + 1, id=2)
        header, body = answer(app)
    assert (header.sequence, body) == (number + 1, response(True, "it is True"))


def test_a_service_that_goes_away_fails_its_requests(app: MockDevice, node: Node) -> None:
    with tool_node("dying") as dying:
        offer(dying, "/dying", echo)
        app.open(client(1, "/dying"))
        number = await_there(app, code="timeout")
        ask(app, number)
    assert failure(app) == (number, "unavailable")


def test_a_slow_service_holds_up_no_other(app: MockDevice, node: Node) -> None:
    may_answer = threading.Event()

    def slowly(request: Any, answer: Any) -> Any:
        may_answer.wait(LIMIT_S)
        return echo(request, answer)

    offer(node, "/fast", echo)
    with tool_node("slow") as slow:
        offer(slow, "/slow", slowly)
        with answering(slow), answering(node):
            app.open(client(1, "/slow"))
            app.open(client(2, "/fast"))
            first = await_there(app, id=2)
            may_answer.set()
            next_slow = await_there(app)
            may_answer.clear()
            ask(app, next_slow)
            for number in range(first, first + 20):
                ask(app, number, id=2)
                header, _ = answer(app)
                assert (header.kind, header.channel) == (Kind.RESPONSE, 2)
            may_answer.set()
            header, _ = answer(app)
            assert (header.kind, header.channel) == (Kind.RESPONSE, 1)


@pytest.mark.parametrize("payload", [CDR_ENCAPSULATION, CDR_ENCAPSULATION + b"\1"])
def test_a_request_that_is_not_of_the_type_is_malformed(payload: bytes, app: MockDevice) -> None:
    assert app.open(client(1, "/set", "rcl_interfaces/srv/GetParameters")).result == "opened"
    ask(app, 8, payload)
    assert failure(app) == (8, "malformed")


def test_an_answer_above_64_kib_is_too_large(app: MockDevice, node: Node) -> None:
    length = 0

    def say(_: Any, answer: Any) -> Any:
        answer.message = "x" * length
        return answer

    offer(node, "/say", say, Trigger)
    app.open(client(1, "/say", "std_srvs/srv/Trigger"))
    with answering(node):
        number = await_there(app, EMPTY)
        length = 65_536 - len(response(True, ""))
        ask(app, number, EMPTY)
        assert len(answer(app)[1]) == 65_536
        length += 1
        ask(app, number + 1, EMPTY)
        assert failure(app) == (number + 1, "too_large")


def test_16_requests_are_under_way_at_most_and_then_the_next_ones_are(
    app: MockDevice, node: Node
) -> None:
    offer(node, "/silent", echo)
    app.open(client(1, "/silent"))
    with answering(node):
        first = await_there(app)
    for number in range(first, first + 17):
        ask(app, number)
    assert failure(app) == (first + 16, "busy")
    with answering(node):
        for begin in (first, first + 17):
            if begin > first:
                for number in range(begin, begin + 16):
                    ask(app, number)
            found = [answer(app) for _ in range(16)]
            assert {it.kind for it, _ in found} == {Kind.RESPONSE}, found
            assert sorted(it.sequence for it, _ in found) == list(range(begin, begin + 16))


@pytest.mark.parametrize(
    ("wanted", "code", "names"),
    [
        (client(1, "/pause", "no_srvs/srv/Such"), "type", ["no_srvs/srv/Such", "source its"]),
        (client(1, "/pause", "std_srvs/srv/Such"), "type", ["std_srvs/srv/Such"]),
        (client(1, "/pause", "std_msgs/msg/Bool"), "type", ["PACKAGE/srv/NAME"]),
        (client(1, "no name"), "name", ["no name"]),
        (client(1, "/pause", layout="b>b"), "layout", ["b>b", "b>bs"]),
        (client(1, "/pause", hash="RIHS01_00"), "layout", [described_service(SET_BOOL).hash]),
        (client(1, "/pause", "std_srvs/srv/Empty"), "type", [SET_BOOL, "std_srvs/srv/Empty"]),
        (client(1, "/robot/list_parameters"), "rules", ["app.call"]),
    ],
)
def test_a_client_that_is_not_opened_is_refused_with_the_reason(
    wanted: Open, code: str, names: list[str], app: MockDevice, node: Node
) -> None:
    offer(node, "/pause", echo)
    app.open(client(9, "/pause"))
    await_there(app, id=9, code="timeout")
    opened = app.open(wanted)
    assert (opened.result, opened.code) == ("refused", code)
    assert [it for it in names if it not in str(opened.reason)] == []


def transform(parent: str, child: str, stamp_ns: int, x: float) -> TFMessage:
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id = parent
    made.header.stamp = Time(nanoseconds=stamp_ns).to_msg()
    made.transform.translation.x = float(x)
    return TFMessage(transforms=[made])


def pose(app: MockDevice) -> tuple[int, int, Pose]:
    """The opening and the stamp of the next pose, and the pose."""
    header, body = answer(app)
    assert header.kind == Kind.POSE, header
    return header.channel, header.capture_ns, Pose.parse(body)


def test_a_pose_follows_the_transforms_and_its_stamp_is_that_of_the_oldest(
    app: MockDevice, node: Node
) -> None:
    latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    moving = node.create_publisher(TFMessage, "/tf", latched)
    node.create_publisher(TFMessage, "/tf_static", latched).publish(transform("a", "b", 7, 1))
    opened = app.open(Open(1, "transform", frame="b", reference="a"))
    assert (opened.result, opened.name, opened.lane) == ("opened", "/tf", "ros")
    assert pose(app) == (1, 0, Pose(1, 0, 0, 0, 0, 0, 1, 0))
    app.open(Open(2, "transform", frame="map", reference="b"))
    await_true(lambda: moving.get_subscription_count() == 1)
    moving.publish(transform("map", "a", SECOND_NS, 10))
    assert pose(app) == (2, SECOND_NS, Pose(-11, 0, 0, 0, 0, 0, 1, SECOND_NS))
    # The hand is newer than its robot: the pose is of the time that both have
    app.open(Open(3, "transform", frame="hand", reference="map"))
    for stamp_ns, x in ((SECOND_NS, 1), (3 * SECOND_NS, 3)):
        moving.publish(transform("a", "hand", stamp_ns, x))
    assert pose(app) == (3, SECOND_NS, Pose(11, 0, 0, 0, 0, 0, 1, SECOND_NS))
    moving.publish(transform("map", "a", 2 * SECOND_NS, 20))
    found = sorted(pose(app) for _ in range(2))
    assert found == [
        (2, 2 * SECOND_NS, Pose(-21, 0, 0, 0, 0, 0, 1, 2 * SECOND_NS)),
        (3, 2 * SECOND_NS, Pose(22, 0, 0, 0, 0, 0, 1, 2 * SECOND_NS)),
    ]


def test_poses_come_no_faster_than_wanted_and_the_last_one_comes(
    app: MockDevice, node: Node
) -> None:
    moving = node.create_publisher(TFMessage, "/tf", QoSProfile(depth=1000))
    app.open(Open(1, "transform", frame="a", reference="map", max_hz=5))
    await_true(lambda: moving.get_subscription_count() == 1)
    began_s = time.monotonic()
    for number in range(1, 501):
        moving.publish(transform("map", "a", number, number))
        time.sleep(0.001)
    found = [pose(app)]
    while found[-1][1] < 500:
        found.append(pose(app))
    assert found[-1][2].x == 500
    assert len(found) <= 2 + 5 * (time.monotonic() - began_s)


def test_transforms_that_nobody_has_open_are_not_subscribed_to(app: MockDevice, node: Node) -> None:
    for id in (1, 2):
        app.open(Open(id, "transform", frame="a", reference="b"))
    await_true(lambda: node.count_subscribers("/tf_static") == 1)
    for id in (1, 2):
        app.wires["control"].send(Kind.CLOSE, Close(id))
    await_true(lambda: node.count_subscribers("/tf_static") == 0)
    await_true(lambda: node.count_subscribers("/tf") == 0)


# The buffer of transforms; expected values are those of pytransform3d


def drawn(chance: random.Random) -> Rigid:
    x, y, z, w = ROTATIONS[chance.randrange(len(ROTATIONS))]
    a, b, c = (chance.uniform(-9, 9) for _ in range(3))
    return Rigid((a, b, c), (x, y, z, w))


def position_and_quaternion(transform: Rigid) -> Any:
    x, y, z, w = transform.rotation
    return np.array([*transform.translation, w, x, y, z])


def matrix(transform: Rigid) -> Any:
    return transform_from_pq(position_and_quaternion(transform))


def interpolated(stamps: list[int], transforms: list[Rigid], stamp_ns: int) -> Any:
    """The matrix at a stamp, by pytransform3d, whose quaternions begin with the real part."""
    after = min(max(1, bisect_left(stamps, stamp_ns)), len(stamps) - 1)
    begin, end = (position_and_quaternion(it) for it in transforms[after - 1 : after + 1])
    share = (stamp_ns - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
    turn = quaternion_slerp(begin[3:], end[3:], share, shortest_path=True)
    return transform_from_pq([*(begin[:3] + share * (end[:3] - begin[:3])), *turn])


class Edge(NamedTuple):
    parent: str
    stamps: list[int]
    transforms: list[Rigid]
    is_static: bool


def tree(chance: random.Random) -> dict[str, Edge]:
    """The transforms of up to eight frames below the frame 0, each after that of its parent."""
    edges: dict[str, Edge] = {}
    for number in range(1, chance.randrange(2, 9)):
        is_static = chance.random() < 0.3
        stamps = sorted(chance.sample(range(1, 1000), 1 if is_static else 3))
        transforms = [drawn(chance) for _ in stamps]
        edges[f"{number}"] = Edge(f"{chance.randrange(number)}", stamps, transforms, is_static)
    return edges


def test_poses_in_10000_random_trees_are_those_of_pytransform3d() -> None:
    chance = random.Random(1)
    for _ in range(10_000):
        buffer, edges = TransformBuffer(), tree(chance)
        for child, edge in edges.items():
            for stamp_ns, transform in zip(edge.stamps, edge.transforms, strict=True):
                buffer.add(edge.parent, child, stamp_ns, transform, is_static=edge.is_static)
        frame, reference = (f"{chance.randrange(len(edges) + 1)}" for _ in range(2))
        chain = branch(frame, edges) ^ branch(reference, edges)
        moving = [edges[it].stamps[-1] for it in chain if not edges[it].is_static]
        newest_ns = min(moving, default=0)
        trees = TransformManager()
        for child in chain:
            edge = edges[child]
            at = matrix(edge.transforms[0])
            if not edge.is_static:
                at = interpolated(edge.stamps, edge.transforms, max(edge.stamps[0], newest_ns))
            trees.add_transform(child, edge.parent, at)
        expected = np.eye(4) if frame == reference else trees.get_transform(frame, reference)
        found = buffer.look_up(frame, reference)
        assert np.abs(matrix(found.pose) - expected).max() < 1e-9
        assert (found.stamp_ns, found.newest_ns) == (newest_ns, newest_ns)


def branch(frame: str, edges: dict[str, Edge]) -> set[str]:
    """A frame and its ancestors, but the root."""
    found = set()
    while frame in edges:
        found.add(frame)
        frame = edges[frame].parent
    return found


def test_a_message_of_ros_is_read_and_one_that_ends_too_early_is_refused() -> None:
    message = TFMessage()
    for child in ("a", "bcd", "efghi"):
        stamped = TransformStamped(child_frame_id=child)
        stamped.header.frame_id = "map"
        stamped.header.stamp.sec, stamped.header.stamp.nanosec = 3, 4
        stamped.transform.translation.x = float(len(child))
        message.transforms.append(stamped)
    payload = serialize_message(message)
    buffer = TransformBuffer()
    buffer.add_message(payload, is_static=False)
    assert buffer.look_up("efghi", "bcd").pose.translation == (2, 0, 0)
    assert buffer.look_up("a", "map").stamp_ns == 3 * SECOND_NS + 4
    for length in range(4, len(payload) - 8):
        with pytest.raises(ValueError, match=r"too early|before its byte"):
            TransformBuffer().add_message(payload[:length], is_static=False)
    with pytest.raises(ValueError, match="too early"):
        TransformBuffer().add_message(b"\0\1\0\0" + struct.pack("<I", 1 << 31), is_static=False)


def test_frames_that_nothing_connects_and_circles_have_no_pose() -> None:
    buffer = TransformBuffer()
    buffer.add("map", "robot", 1, NOTHING, is_static=True)
    buffer.add("other", "table", 1, NOTHING, is_static=True)
    with pytest.raises(TransformError, match="robot, which is below map, with table"):
        buffer.look_up("robot", "table")
    with pytest.raises(TransformError, match="nowhere"):
        buffer.look_up("robot", "nowhere")
    buffer.add("robot", "map", 1, NOTHING, is_static=True)
    with pytest.raises(TransformError, match="ancestor"):
        buffer.look_up("robot", "map")
    buffer.add("world", "map", 2, NOTHING, is_static=True)
    assert buffer.look_up("robot", "world").stamp_ns == 0


def test_a_chain_is_seen_as_stale_one_period_after_one_of_its_publishers_has_stopped() -> None:
    buffer, period_ns = TransformBuffer(), SECOND_NS // 30
    for number in range(1, 61):
        now_ns = number * period_ns
        buffer.add("map", "odom", now_ns, NOTHING, is_static=False)
        if number <= 30:
            buffer.add("odom", "base_link", now_ns, NOTHING, is_static=False)
        age_ns = now_ns - buffer.look_up("base_link", "map").newest_ns
        assert (age_ns >= period_ns) == (number > 30)


def test_what_is_no_transform_is_refused_and_counted() -> None:
    buffer = TransformBuffer()
    wrong = [Rigid(rotation=(0, 0, 0, 0)), Rigid((float("nan"), 0, 0)), Rigid((0, 0, float("inf")))]
    for transform in wrong:
        buffer.add("map", "robot", 1, transform, is_static=False)
    buffer.add("map", "map", 1, NOTHING, is_static=False)
    assert buffer.refused == 4
    buffer.add("map", "robot", 1, Rigid(rotation=(0, 0, 0, 7)), is_static=False)
    assert buffer.look_up("robot", "map").pose == NOTHING
    for number in range(10_000):
        buffer.add("map", f"{number}", 1, NOTHING, is_static=True)
    assert buffer.refused == 5


def test_transforms_of_any_order_are_kept_for_10_s_and_memory_is_bounded() -> None:
    chance, buffer = random.Random(2), TransformBuffer()
    numbers = list(range(1, 9))
    chance.shuffle(numbers)
    for number in (*numbers, 5):
        buffer.add("map", "robot", number * SECOND_NS, Rigid((number, 0, 0)), is_static=False)
    buffer.add("robot", "hand", 5 * SECOND_NS // 2, NOTHING, is_static=False)
    assert buffer.look_up("hand", "map").pose.translation == (2.5, 0, 0)
    for number in range(100_000):
        buffer.add("map", "robot", 9 * SECOND_NS + number, NOTHING, is_static=False)
    assert len(buffer._edges["robot"].stamps) <= 2001
    for number in range(9, 100):
        buffer.add("map", "robot", number * SECOND_NS, NOTHING, is_static=False)
    assert len(buffer._edges["robot"].stamps) <= 22
