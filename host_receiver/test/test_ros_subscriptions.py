"""From publishers of ROS to a scripted device, over a receiver in a process of its own."""

import array
import functools
import random
import resource
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from configurations import only
from mock_device import MockDevice
from repeated import begin
from ros_messages import TYPES, message, string
from ros_processes import Child, Client, Receiver, environment, segments
from waiting import LIMIT_S, await_true

pytest.importorskip("rclpy", reason="rclpy is not installed")

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String, UInt8MultiArray
from test_msgs import msg as test_msgs  # type: ignore[import-untyped]
from test_msgs.message_fixtures import get_test_msg  # type: ignore[import-untyped]

from ml2_receiver.generated.type_hashes import HASHES
from ml2_receiver.ros.app_subscriptions import Heard
from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.layout import described, exact, plain
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_receiver.topics.plain_messages import status_name
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import Error
from ml2_receiver.wire.opening_bodies import Close, Closed, Open, SubscriptionStatus

CONFIG = only("battery: {enabled: true}, app: {subscribe: ['/**']}")
STRING, BYTES = "std_msgs/msg/String", "std_msgs/msg/UInt8MultiArray"
EMPTY = "structure_needs_at_least_one_member"
STRING_HASH = HASHES[STRING]
VOLATILE = DurabilityPolicy.VOLATILE
RELIABLE = QoSProfile(depth=100)
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
# As Fast DDS with ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST.
CYCLONE = """
<CycloneDDS><Domain Id="any">
  <General>
    <Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
    <Peers><Peer address="127.0.0.1"/></Peers>
  </Discovery>
</Domain></CycloneDDS>
"""
# Publishes as many messages of 60 kB as each line says. With shared memory for a burst of them:
# Fast DDS loses them otherwise, and grows with each that it loses.
LARGE_PUBLISHER = """
import os, sys, time, rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import String, UInt8MultiArray
from ml2_receiver.ros.fastdds import apply_default_profile
apply_default_profile(os.environ, sends_images=True)
rclpy.init()
publisher = rclpy.create_node("large").create_publisher(String, "/large", QoSProfile(depth=200))
while not publisher.get_subscription_count():
    time.sleep(0.01)
published = 0
print(published, flush=True)
for line in sys.stdin:
    for _ in range(int(line)):
        published += 1
        publisher.publish(String(data=f"{published} " + "x" * 60_000))
    print(published, flush=True)
"""
# Twice what all queues of a session hold
MOST_GROWTH_BYTES = 32 << 20
KEPT = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TEST_TYPES = [it for it in vars(test_msgs) if it[0].isupper()]


@pytest.fixture
def app(receiver: Receiver) -> Iterator[MockDevice]:
    with MockDevice(receiver.address, says_ping=True, has_ros=True) as app:
        begin(app)
        yield app


@pytest.fixture
def node(ros_of_children: None) -> Iterator[Node]:
    with tool_node("robot") as node:
        yield node


def type_of(messages: list[Any]) -> Any:
    return type(messages[0])


def read(payload: bytes, type: str) -> Any:
    """A message as rosbags reads it, or as rclpy does if it has a wstring."""
    name = type.rpartition("/")[2]
    if name == "WStrings":
        return deserialize_message(payload, getattr(test_msgs, name))
    return rosbags_types().deserialize_cdr(payload, type)


@functools.cache
def rosbags_types() -> Any:
    store = get_typestore(Stores.ROS2_JAZZY)
    folder = Path(str(test_msgs.__file__)).parents[5] / "share/test_msgs/msg"
    known: dict[str, Any] = {}
    for file in folder.glob("*.msg"):
        known |= get_types_from_msg(file.read_text("utf-8"), f"test_msgs/msg/{file.stem}")
    store.register(known)
    return store


def values(message: Any) -> Any:
    """The fields of a message of rclpy or rosbags, all the way down."""
    if hasattr(message, "get_fields_and_field_types"):
        fields = list(message.get_fields_and_field_types())
    elif hasattr(message, "__dataclass_fields__"):
        fields = [it for it in message.__dataclass_fields__ if it[0].islower()]
    elif isinstance(message, list | tuple | np.ndarray | array.array):
        return [values(it) for it in message]
    else:
        return number(message)
    return {it: values(getattr(message, it)) for it in fields if it != EMPTY}


def number(value: Any) -> Any:
    """A number or a text, whatever library made it: an octet is bytes or a signed number."""
    if isinstance(value, bytes):
        return int.from_bytes(value, signed=True)
    return value.item() if hasattr(value, "item") else value


def subscription(id: int, name: str, type: str = STRING, **more: Any) -> Open:
    return Open(id, "subscription", name, type, **more)


def await_subscriber(publisher: Publisher, count: int = 1) -> None:
    await_true(lambda: publisher.get_subscription_count() == count)


def text(payload: bytes) -> str:
    return str(TYPES.deserialize_cdr(payload, STRING).data)  # type: ignore[attr-defined]


def said(app: MockDevice, count: int) -> list[tuple[int, str]]:
    """The numbers and texts of the next messages."""
    messages = (app.message() for _ in range(count))
    return [(header.sequence, text(payload)) for header, payload in messages]


def quality(node: Node, name: str) -> tuple[ReliabilityPolicy, DurabilityPolicy] | None:
    """Returns the quality of service of the receiver's only subscription."""
    found = node.get_subscriptions_info_by_topic(name)
    if len(found) != 1:
        return None
    return found[0].qos_profile.reliability, found[0].qos_profile.durability


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


def test_large_messages_arrive_on_a_lane_of_their_own_while_the_app_takes_them(
    app: MockDevice, node: Node
) -> None:
    wanted = subscription(1, "/map", BYTES, keep="all")
    assert app.open(wanted).lane == "bulk_1"
    assert app.open(subscription(2, "/said")).lane == "ros"
    assert app.open(subscription(3, "/said", bulk=True)).lane == "bulk_2"
    lane = app.join("bulk_1")
    publisher = node.create_publisher(UInt8MultiArray, "/map", RELIABLE)
    await_subscriber(publisher)
    most = (16 << 20) - len(serialize_message(UInt8MultiArray()))
    sizes = [1, 1_000_000, most, 5]
    for number, size in enumerate(sizes):
        sent = UInt8MultiArray(data=random.Random(number).randbytes(size))
        publisher.publish(sent)
        header, payload = app.message("bulk_1")
        assert (header.channel, header.sequence) == (1, number)
        assert deserialize_message(payload, UInt8MultiArray) == sent
        lane.send(Kind.TAKEN, channel=1, sequence=number)


def bulk_processes(receiver: Receiver) -> list[psutil.Process]:
    """Returns the process that takes large messages, and its spare."""
    running = of_large_messages(psutil.Process(receiver.process.pid).children())
    return sorted(running, key=psutil.Process.create_time)


def of_large_messages(processes: list[psutil.Process]) -> list[psutil.Process]:
    """Returns those that take large messages and have not ended."""
    found: list[psutil.Process] = []
    for process in processes:
        with suppress(psutil.NoSuchProcess):
            if any("bulk_child" in word for word in process.cmdline()):
                found.append(process)
    return found


def test_a_killed_process_of_large_messages_is_replaced_and_what_it_lost_is_counted(
    app: MockDevice, node: Node, receiver: Receiver
) -> None:
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(UInt8MultiArray, "/map", kept)
    app.open(subscription(1, "/map", BYTES))
    lane = app.join("bulk_1")
    # So the receiver knows the publisher, whose numbers tell what is lost
    await_true(lambda: quality(node, "/map") == (RELIABLE.reliability, kept.durability))
    published = 0
    over = threading.Event()

    def publish() -> None:
        nonlocal published
        publisher.publish(UInt8MultiArray(data=bytes(100_000)))
        published += 1

    def publish_on() -> None:
        while not over.wait(0.02):
            publish()

    def take_one_after(ns: int) -> None:
        """Takes messages until one comes that was published after this time."""
        is_after = False
        while not is_after:
            header, _ = app.message("bulk_1")
            lane.send(Kind.TAKEN, channel=1, sequence=header.sequence)
            is_after = header.capture_ns > ns

    def kill() -> None:
        await_true(lambda: len(bulk_processes(receiver)) == 2)
        taking, spare = bulk_processes(receiver)
        taking.kill()
        await_true(lambda: bulk_processes(receiver)[:1] == [spare])

    # Books begin with the first message that is taken
    publish()
    take_one_after(0)
    shared = segments(bulk_processes(receiver)[0].pid)
    assert max(it.stat().st_size for it in shared) < 2 << 20
    with ThreadPoolExecutor(1) as beside:
        beside.submit(publish_on)
        try:
            for _ in range(2):
                kill()
                take_one_after(time.time_ns())
        finally:
            over.set()
    counts: dict[str, int] = {}
    while counts.get("produced", 0) + counts.get("missed", 0) < published:
        counts = book(node, "/map")
    assert counts["produced"] + counts["missed"] == published
    assert counts["missed"] > 0


def test_the_processes_of_large_messages_give_way_to_the_receiver_and_end_when_it_is_killed(
    app: MockDevice, node: Node, receiver: Receiver
) -> None:
    app.open(subscription(1, "/map", BYTES))
    app.join("bulk_1")
    publisher = node.create_publisher(UInt8MultiArray, "/map", RELIABLE)
    await_subscriber(publisher)
    publisher.publish(UInt8MultiArray(data=b"1"))
    await_true(lambda: len(bulk_processes(receiver)) == 2)
    processes = bulk_processes(receiver)
    own = psutil.Process(receiver.process.pid).nice()
    await_true(lambda: all(it.nice() > own for it in processes))
    receiver.process.kill()
    await_true(lambda: not of_large_messages(processes))


def test_a_queue_of_images_does_not_hold_back_small_messages(node: Node) -> None:
    large, small = (node.create_publisher(String, it, RELIABLE) for it in ("/large", "/small"))
    begun, published, over = threading.Event(), threading.Event(), threading.Event()
    order: list[int] = []

    def take(payload: bytes) -> None:
        begun.set()
        published.wait(LIMIT_S)
        order.append(len(payload))
        if len(order) == 1 + 10 + 60:
            over.set()

    wanted = [RawSubscription(STRING, it, RELIABLE, take) for it in ("/large", "/small")]
    with tool_node("taker") as taking:
        taker = RawTaker(taking, wanted, failed=lambda _, error: pytest.fail(str(error)))
        await_true(lambda: all(it.get_subscription_count() for it in (large, small)))
        large.publish(String(data="x" * 100_000))
        assert begun.wait(LIMIT_S)
        for publisher, count, size in ((large, 10, 100_000), (small, 60, 100)):
            for _ in range(count):
                publisher.publish(String(data="x" * size))
            assert publisher.wait_for_all_acked(Duration(seconds=LIMIT_S))
        published.set()
        assert over.wait(LIMIT_S)
        taker.stop()
    last_small = max(at for at, size in enumerate(order) if size < 1000)
    assert sum(size > 1000 for size in order[:last_small]) < 4


def test_publishers_with_another_quality_of_service_are_heard_again(
    app: MockDevice, node: Node
) -> None:
    app.open(subscription(1, "/said", keep="all", depth=100))
    reliable = node.create_publisher(String, "/said", RELIABLE)
    await_true(lambda: quality(node, "/said") == (RELIABLE.reliability, VOLATILE))
    best_effort = node.create_publisher(String, "/said", BEST_EFFORT)
    await_true(lambda: quality(node, "/said") == (BEST_EFFORT.reliability, VOLATILE))
    for publisher in (reliable, best_effort):
        await_subscriber(publisher)
        publisher.publish(String(data="both"))
    assert [it for _, it in said(app, 2)] == ["both", "both"]
    node.destroy_publisher(reliable)
    node.destroy_publisher(best_effort)
    latched = node.create_publisher(String, "/said", LATCHED)
    latched.publish(String(data="before"))
    assert said(app, 1) == [(2, "before")]
    # With another publisher, and without it again: what it has kept comes no second time.
    other = node.create_publisher(String, "/said", RELIABLE)
    await_true(lambda: quality(node, "/said") == (RELIABLE.reliability, VOLATILE))
    node.destroy_publisher(other)
    await_true(lambda: quality(node, "/said") == (RELIABLE.reliability, LATCHED.durability))
    await_subscriber(latched)
    latched.publish(String(data="after"))
    assert said(app, 1) == [(3, "after")]


def test_a_publisher_that_comes_back_best_effort_is_heard_within_2_s(
    app: MockDevice, node: Node
) -> None:
    app.open(subscription(1, "/said", keep="all", depth=100))

    def unheard_s(attempt: int) -> float:
        """Returns how old the new publisher was when it published the first message that came."""
        reliable = node.create_publisher(String, "/said", RELIABLE)
        await_true(lambda: quality(node, "/said") == (RELIABLE.reliability, VOLATILE))
        await_subscriber(reliable)
        node.destroy_publisher(reliable)
        is_heard = threading.Event()
        began_ns = time.time_ns()
        best_effort = node.create_publisher(String, "/said", BEST_EFFORT)

        def publish() -> None:
            while not is_heard.wait(0.01):
                best_effort.publish(String(data=str(attempt)))

        with ThreadPoolExecutor(1) as beside:
            beside.submit(publish)
            header, payload = app.message()
            while text(payload) != str(attempt):
                header, payload = app.message()
            is_heard.set()
        node.destroy_publisher(best_effort)
        return (header.capture_ns - began_ns) / 1e9

    # A machine that stands still delays the one or other
    times_s = sorted(unheard_s(attempt) for attempt in range(7))
    assert times_s[2] < 2, times_s


def test_latched_messages_come_again_in_each_session_and_nothing_twice(
    app: MockDevice, node: Node
) -> None:
    publisher = node.create_publisher(String, "/said", LATCHED)
    for word in ("a", "b", "c"):
        publisher.publish(String(data=word))
    expected = 0
    for session in range(3):
        if session:
            app.disconnect()
            app.start()
        wanted = subscription(1, "/said", keep="all", received=expected)
        is_latched = app.open(wanted).latched
        assert is_latched or not session  # it may not know the publisher yet
        await_true(lambda: quality(node, "/said") == (RELIABLE.reliability, LATCHED.durability))
        publisher.publish(String(data=f"{session}"))
        count = 4 + session
        words = ["a", "b", "c", *map(str, range(session + 1))]
        numbers = range(expected, expected + count)
        assert said(app, count) == list(zip(numbers, words, strict=True))
        expected += count


@pytest.mark.parametrize(
    ("wanted", "code", "names"),
    [
        (subscription(1, "/said", "no_msgs/msg/Such"), "type", ["no_msgs/msg/Such"]),
        (subscription(1, "/said", "std_msgs/msg/Such"), "type", ["std_msgs/msg/Such"]),
        (subscription(1, "/said", "this.that/msg/Such"), "type", ["PACKAGE/msg/NAME"]),
        (subscription(1, "no name"), "name", ["no name"]),
        (subscription(1, "/said", hash="RIHS01_00"), "layout", ["RIHS01_00", STRING_HASH]),
        (subscription(1, "/said", layout="4"), "layout", [" 4,", " s"]),
        (subscription(1, "n" * 255), "name", ["nnn"]),
        (subscription(1, "/said", "std_msgs/msg/" + "n" * 240), "type", ["nnn"]),
        (subscription(1, "/said", layout="\0" * 600), "layout", [" s"]),
        (subscription(1, "/said", hash="\0" * 600), "layout", [STRING_HASH]),
        (subscription(1, "/rosout", "rcl_interfaces/msg/Log"), "rules", ["/rosout"]),
        (Open(1, "client", "/said", "std_srvs/srv/Trigger"), "rules", ["app.call"]),
        (Open(1, "service", "/said", "std_srvs/srv/Trigger"), "rules", ["app.offer"]),
    ],
)
def test_what_is_not_opened_is_refused_with_the_reason(
    wanted: Open, code: str | None, names: list[str], app: MockDevice
) -> None:
    opened = app.open(wanted)
    assert (opened.result, opened.code) == ("refused", code)
    assert [it for it in names if it not in str(opened.reason)] == []


def test_rules_of_a_file_that_is_read_again_hold_at_once(
    app: MockDevice, client: Client, config: Path
) -> None:
    assert app.open(subscription(1, "/said")).result == "opened"
    config.write_text(CONFIG.replace("/**", "/allowed"))
    assert client.ask("trigger", "reload") == [True, ""]
    closed = Closed.parse(app.await_control(Kind.CLOSED))
    assert closed == Closed(1, "no rule in app.subscribe has /said", "rules")
    assert app.open(subscription(2, "/said")).code == "rules"
    assert app.open(subscription(3, "/allowed")).result == "opened"


def test_an_equal_type_is_found_by_hash_or_layout(app: MockDevice) -> None:
    assert app.open(subscription(1, "/said", hash=STRING_HASH)).checked == "hash"
    assert app.open(subscription(2, "/said", layout="s")).checked == "layout"
    assert app.open(subscription(3, "/said")).checked == "no"


def test_a_type_of_a_peer_imports_nothing_but_packages_of_messages() -> None:
    for type in ("this.that/msg/Such", "this/msg/Such", "std_msgs.msg/msg/String", "this/msg/"):
        with pytest.raises(ImportError):
            described(type)
    assert "this" not in sys.modules


def test_messages_that_ros_lost_are_known_while_there_is_one_publisher() -> None:
    heard = Heard()
    heard.publishers = (b"a",)
    assert [heard.missed(it) for it in (3, 4, 7, 8)] == [0, 0, 2, 0]
    heard.publishers = (b"a", b"b")
    assert [heard.missed(it) for it in (20, 1, 30)] == [0, 0, 0]
    heard.publishers = (b"b",)
    assert [heard.missed(it) for it in (31, 33)] == [0, 1]


def of_rosbags(message: Any, type: str) -> Any:
    """A message of rclpy, which writes bytes behind it that rosbags does not take."""
    data = serialize_message(message)
    for behind in range(200):
        with suppress(SerdeError):
            return rosbags_types().deserialize_cdr(data[: len(data) - behind], type)
    raise AssertionError(type)


def test_big_endian_messages_and_those_of_rclpy_become_what_rosbags_writes() -> None:
    for name in TEST_TYPES:
        type = f"test_msgs/msg/{name}"
        if name == "WStrings":  # which rosbags does not know
            continue
        own = described(type)
        for each in get_test_msg(name):
            made = of_rosbags(each, type)
            big, little = (
                bytes(rosbags_types().serialize_cdr(made, type, little_endian=is_little))
                for is_little in (False, True)
            )
            assert plain(big, own.layout) == little, type
            assert exact(serialize_message(each), own.layout) == little, type
            with pytest.raises(ValueError, match="ends before"):
                plain(big[:-1], own.layout)


@contextmanager
def cyclone_writer(topic: str, user_data: bytes = b"") -> Iterator[Callable[[str], None]]:
    """Writes texts with Cyclone DDS where ROS has its topic of strings."""
    made: Any = make_idl_struct("String_", "std_msgs.msg.dds_.String_", {"data": str})
    number = int(environment()["ROS_DOMAIN_ID"])
    domain = Domain(number, CYCLONE)
    participant = DomainParticipant(number)
    policies = [Policy.Reliability.Reliable(duration(seconds=1)), Policy.Userdata(user_data)]
    qos = Qos(*policies, Policy.History.KeepLast(5))
    there = DataWriter(participant, Topic(participant, f"rt{topic}", made, qos=qos), qos=qos)

    def write(text: str) -> None:
        await_true(lambda: bool(there.get_matched_subscriptions()))
        there.write(made(data=text))

    yield write
    del domain  # which ends with the last that is of it


def test_a_publisher_of_cyclonedds_is_heard(app: MockDevice) -> None:
    app.open(subscription(1, "/said", keep="all"))
    with cyclone_writer("/said") as write:
        write("hello")
        write("again")
        assert said(app, 2) == [(0, "hello"), (1, "again")]


def test_a_publisher_of_another_version_of_the_type_is_refused(app: MockDevice) -> None:
    other = f"RIHS01_{'0' * 63}1"
    assert app.open(subscription(1, "/said")).result == "opened"
    with cyclone_writer("/said", f"typehash={other};".encode()):
        closed = Closed.parse(app.await_control(Kind.CLOSED))
        opened = app.open(subscription(2, "/said"))
    assert (closed.id, closed.code) == (1, "type")
    assert other in closed.reason
    assert STRING_HASH in closed.reason
    assert (opened.result, opened.code) == ("refused", "type")
    assert other in str(opened.reason)
    assert STRING_HASH in str(opened.reason)


def test_foreign_encapsulations_are_made_plain_or_refused(app: MockDevice, node: Node) -> None:
    app.open(subscription(1, "/said", keep="all"))
    publisher = node.create_publisher(String, "/said", RELIABLE)
    await_subscriber(publisher)
    big = bytes(TYPES.serialize_cdr(message(STRING, "big"), STRING, little_endian=False))
    assert big[:2] == b"\0\0"
    publisher.publish(big)
    publisher.publish(b"\0\1\0\3" + string("options")[4:])
    for expected in ("big", "options"):
        _, payload = app.message()
        assert payload.startswith(string(expected))
    publisher.publish(b"\0\3\0\0" + string("parameters")[4:])
    closed = Closed.parse(app.await_control(Kind.CLOSED))
    assert (closed.id, closed.code) == (1, "type")
    assert "PL_CDR" in closed.reason


def test_all_of_test_msgs_arrive_as_rosbags_reads_them(app: MockDevice, node: Node) -> None:
    sent: dict[int, tuple[str, list[Any]]] = {}
    for id, type in enumerate(sorted(TEST_TYPES), 1):
        messages = get_test_msg(type)
        publisher = node.create_publisher(type_of(messages), f"/of_{type}", KEPT)
        for each in messages:
            publisher.publish(each)
        sent[id] = f"test_msgs/msg/{type}", messages
    for id, (type, _messages) in sent.items():
        name = f"/of_{type.rpartition('/')[2]}"
        wanted = subscription(id, name, type, keep="all", depth=100, bulk=False)
        assert app.open(wanted).result == "opened"
    fitting = {
        id: [it for it in messages if len(serialize_message(it)) <= 1 << 16]
        for id, (_, messages) in sent.items()
    }
    assert fitting != {id: messages for id, (_, messages) in sent.items()}  # one is too large
    taken: dict[int, list[bytes]] = {id: [] for id in sent}
    for _ in range(sum(map(len, fitting.values()))):
        header, payload = app.message()
        taken[header.channel].append(payload)
    for id, (type, _messages) in sent.items():
        decoded = [values(read(payload, type)) for payload in taken[id]]
        assert decoded == [values(each) for each in fitting[id]], type


def rows(node: Node) -> dict[str, dict[str, str]]:
    """The next rows of /diagnostics, by name."""
    arrays: list[DiagnosticArray] = []
    made = node.create_subscription(DiagnosticArray, "/diagnostics", arrays.append, 1)
    deadline_s = time.monotonic() + LIMIT_S
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    while not arrays and time.monotonic() < deadline_s:
        executor.spin_once(timeout_sec=1)
    executor.shutdown()
    node.destroy_subscription(made)
    (array, *_) = arrays
    return {it.name: {pair.key: pair.value for pair in it.values} for it in array.status}


def book(node: Node, topic: str) -> dict[str, int]:
    """The counts in the row of a subscription; fails if they do not say all."""
    # The receiver of the test before may still say its last
    while (values := rows(node).get(status_name("", f"subscription {topic}"))) is None:
        pass
    counts = {what: int(value) for what, value in values.items() if value.isdecimal()}
    dropped = sum(count for what, count in counts.items() if what.startswith("dropped."))
    assert counts["produced"] == counts["sent"] + counts["waiting"] + dropped
    return counts


def test_1000_messages_per_second_arrive_in_order(app: MockDevice, node: Node) -> None:
    app.open(subscription(1, "/fast", keep="all", depth=100))
    kept = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(String, "/fast", kept)
    # So the receiver knows the publisher, whose numbers tell what is lost
    await_true(lambda: quality(node, "/fast") == (RELIABLE.reliability, kept.durability))
    await_subscriber(publisher)
    count, padding = 3000, "x" * 88

    def publish() -> None:
        begin_s = time.monotonic()
        for number in range(count):
            publisher.publish(String(data=f"{number:04}{padding}"))
            time.sleep(max(0.0, begin_s + number / 1000 - time.monotonic()))

    with ThreadPoolExecutor(1) as beside:
        publishing = beside.submit(publish)
        numbers: list[int] = []
        while not numbers or numbers[-1] != count - 1:
            payload = app.message()[1]
            assert text(payload)[4:] == padding
            numbers.append(int(text(payload)[:4]))
        publishing.result()
    assert numbers == sorted(set(numbers))
    await_true(lambda: book(node, "/fast")["waiting"] == 0)
    counts = book(node, "/fast")
    assert counts["sent"] == len(numbers)
    # A machine that stands still may lose messages, and counts them all but the first ones.
    lost = counts.get("dropped.queue_full", 0) + counts["missed"]
    gaps = sum(later - earlier - 1 for earlier, later in pairwise(numbers))
    assert gaps <= lost <= gaps + numbers[0]


@pytest.mark.parametrize("keep", ["latest", "all"])
def test_a_device_that_reads_slowly_costs_neither_session_nor_memory(
    keep: str, app: MockDevice, node: Node, receiver: Receiver
) -> None:
    app.open(subscription(1, "/large", keep=keep, depth=100))
    dropped = "dropped.superseded" if keep == "latest" else "dropped.queue_full"
    arrived, published, last = list[int](), 0, 0

    def take() -> None:
        nonlocal last
        header, payload = app.message()
        arrived.append(header.sequence)
        last = int(text(payload).partition(" ")[0])

    with Child("-c", LARGE_PUBLISHER) as publisher:
        publisher.line()
        before_bytes = own_bytes(receiver)
        while book(node, "/large").get(dropped, 0) * 60_000 < 4 * MOST_GROWTH_BYTES:
            assert publisher.process.stdin is not None
            for _ in range(20):  # between two diagnostics, for which each book() waits
                publisher.process.stdin.write("50\n")
                publisher.process.stdin.flush()
                published = int(publisher.line())
                take()
        assert own_bytes(receiver) - before_bytes < MOST_GROWTH_BYTES

        app.exchange_time(1)  # the session lives, and its other lanes go on
        assert book(node, "/large")["waiting"] <= (2 if keep == "latest" else 101)
        while last < published:
            take()
    await_true(lambda: book(node, "/large")["waiting"] == 0)
    counts = book(node, "/large")
    assert arrived == sorted(set(arrived))
    assert (counts["sent"], counts["produced"]) == (len(arrived), arrived[-1] + 1)


def own_bytes(receiver: Receiver) -> int:
    """The memory of the process without what it shares, such as DDS's."""
    statm = Path(f"/proc/{receiver.process.pid}/statm").read_text()
    _, resident, shared, *_ = map(int, statm.split())
    return (resident - shared) * resource.getpagesize()


def test_64_names_are_open_at_most_and_each_id_once(app: MockDevice) -> None:
    for id in range(1, 65):
        assert app.open(subscription(id, f"/name_{id}")).result == "opened"
    more = app.open(subscription(65, "/more"))
    assert (more.result, more.code) == ("refused", "busy")
    app.wires["control"].send(Kind.CLOSE, Close(1))
    assert Closed.parse(app.await_control(Kind.CLOSED)).id == 1
    assert app.open(subscription(66, "/more")).result == "opened"
    app.wires["control"].send(Kind.OPEN, subscription(65, "/again"))
    error = Error.parse(app.await_control(Kind.ERROR))
    assert (error.code, error.fatal) == ("unexpected", True)


def test_a_flood_of_ids_leaves_no_subscription_behind(app: MockDevice, node: Node) -> None:
    for id in range(1, 1001):
        app.open(subscription(id, f"/name_{id % 7}"))
        app.wires["control"].send(Kind.CLOSE, Close(id))
        app.await_control(Kind.CLOSED)
    names = [f"/name_{it}" for it in range(7)]
    await_true(lambda: not any(node.count_subscribers(name) for name in names))
    assert app.open(subscription(2000, "/name_1")).result == "opened"


def test_the_row_of_a_subscription_has_what_the_app_counts(app: MockDevice, node: Node) -> None:
    app.open(subscription(3, "/said"))
    counted = SubscriptionStatus(received=9, taken=5, superseded=1, queue_full=2, undecodable=1)
    app.status(openings={"3": counted})

    def counts() -> dict[str, str]:
        return rows(node).get(status_name("", "subscription /said"), {})

    while "app.received" not in (found := counts()):
        pass
    assert (found["id"], found["message_type"]) == ("3", STRING)
    expected = {f"app.{what}": str(count) for what, count in vars(counted).items()}
    assert expected.items() <= found.items()
