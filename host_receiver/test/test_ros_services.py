"""From a scripted device to services of ROS, over a receiver in a process of its own."""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any

import pytest

from configurations import only
from mock_device import MockDevice
from ros_processes import Receiver

pytest.importorskip("rclpy", reason="rclpy is not installed")

from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_srvs.srv import SetBool, Trigger

from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.layout import described_service
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, Header
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.opening_bodies import Failure, Open
from waiting import LIMIT_S

CONFIG = only("battery: {enabled: true}, app: {call: ['/**']}")
SET_BOOL = "std_srvs/srv/SetBool"
TRUE, EMPTY = CDR_ENCAPSULATION + b"\1", CDR_ENCAPSULATION + b"\0"
SECOND_NS = 1_000_000_000
LONG_NS = int(LIMIT_S) * SECOND_NS


@pytest.fixture
def receiver(config: Any) -> Iterator[Receiver]:
    with Receiver(config, "--insecure-control") as receiver:
        yield receiver


@pytest.fixture
def app(receiver: Receiver) -> Iterator[MockDevice]:
    with MockDevice(receiver.address, says_ping=True, has_ros=True) as app:
        app.start()
        yield app


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


def await_there(app: MockDevice, payload: bytes = TRUE, id: int = 1) -> int:
    """Asks until the service is known, and takes the answer; returns the number that follows.

    A service whose node is not spun does not answer in time.
    """
    for number in count():
        ask(app, number, payload, SECOND_NS // 10, id)
        header, body = answer(app)
        if header.kind == Kind.RESPONSE or Failure.parse(body).code == "timeout":
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
        number = await_there(app)
        ask(app, number)
    assert failure(app) == (number, "unavailable")


def test_a_slow_service_holds_up_no_other(app: MockDevice, node: Node) -> None:
    may_answer = threading.Event()

    def slowly(request: Any, answer: Any) -> Any:
        may_answer.wait(LIMIT_S)
        return echo(request, answer)

    with tool_node("slow") as slow, answering(slow), answering(node):
        offer(slow, "/slow", slowly)
        offer(node, "/fast", echo)
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
        (client(1, "/pause", "no_srvs/srv/Such"), "type", ["no_srvs/srv/Such"]),
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
    await_there(app, id=9)
    opened = app.open(wanted)
    assert (opened.result, opened.code) == ("refused", code)
    assert [it for it in names if it not in str(opened.reason)] == []
