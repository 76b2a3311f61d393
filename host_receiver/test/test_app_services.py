"""Services of a scripted device for ROS: each request of ROS has one answer."""

import struct
import time
from collections.abc import Iterator
from typing import Any

import pytest

from configurations import only
from mock_device import MockDevice

pytest.importorskip("rclpy", reason="rclpy is not installed")

from rclpy.client import Client
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_srvs.srv import Empty, SetBool, Trigger
from test_msgs.srv import BasicTypes

from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.layout import described_service, exact
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, Frame
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.opening_bodies import Close, Failure, Open
from ros_client import await_heard
from test_ros_services import EMPTY, TRUE, answering, response
from waiting import LIMIT_S, await_true, is_done

CONFIG = only("custom: {enabled: true}, app: {offer: [/robot/stop]}")
STOP = "/magic_leap2/custom/stop"
TRIGGER, SET_BOOL, NOTHING = "std_srvs/srv/Trigger", "std_srvs/srv/SetBool", "std_srvs/srv/Empty"


@pytest.fixture
def node(ros_of_children: None) -> Iterator[Node]:
    with tool_node("robot") as node, answering(node):
        yield node


def service(id: int = 1, name: str = "custom/stop", type: str = TRIGGER, **more: Any) -> Open:
    return Open(id, "service", name, type, **more)


def client(node: Node, type: Any = Trigger, name: str = STOP) -> Client:
    # Room for all answers: by default ROS keeps ten
    made = node.create_client(type, name, qos_profile=QoSProfile(depth=100))
    assert made.wait_for_service(LIMIT_S)
    await_heard(node, is_done)
    return made


def asked(app: MockDevice) -> Frame:
    frame = app.wires["ros"].receive(time.monotonic() + LIMIT_S)
    assert frame is not None
    assert frame.header.kind == Kind.REQUEST
    return frame


def reply(app: MockDevice, request: Frame, kind: Kind, body: bytes) -> None:
    header = {"channel": request.header.channel, "sequence": request.header.sequence}
    app.wires["ros"].send(kind, body, **header)


def result(future: Any) -> Any:
    await_true(future.done)
    return future.result()


def answered(app: MockDevice, stop: Client, text: str) -> str:
    """Calls the service, lets the app answer with `text`, and returns the text that comes."""
    future = stop.call_async(Trigger.Request())
    reply(app, asked(app), Kind.RESPONSE, response(True, text))
    message: str = result(future).message
    return message


def test_a_request_is_answered_by_the_app(app: MockDevice, node: Node) -> None:
    assert app.welcome.ros is not None
    assert app.welcome.ros.offer
    opened = app.open(service(7, layout="1>bs"))
    assert (opened.result, opened.name, opened.lane) == ("opened", STOP, "ros")
    assert opened.checked == "layout"
    stop = client(node)
    numbers = []
    for text in ("", "stopped", "stopped again"):
        future = stop.call_async(Trigger.Request())
        request = asked(app)
        assert (request.header.channel, bytes(request.body)) == (7, EMPTY)
        assert request.header.capture_ns > 0
        numbers.append(request.header.sequence)
        reply(app, request, Kind.RESPONSE, response(True, text))
        assert result(future) == Trigger.Response(success=True, message=text)
    assert numbers == sorted(set(numbers))


def test_an_absolute_name_is_itself(app: MockDevice, node: Node) -> None:
    assert app.open(service(name="/robot/stop")).name == "/robot/stop"
    future = client(node, name="/robot/stop").call_async(Trigger.Request())
    reply(app, asked(app), Kind.RESPONSE, response(False, "no"))
    assert result(future) == Trigger.Response(success=False, message="no")


def test_a_request_has_no_byte_that_its_client_did_not_set(app: MockDevice, node: Node) -> None:
    assert app.open(service(name="custom/all", type="test_msgs/srv/BasicTypes")).result == "opened"
    ask = client(node, BasicTypes, "/magic_leap2/custom/all")
    for length in range(16):  # as many as may be under way
        text = "x" * length
        ask.call_async(BasicTypes.Request(bool_value=True, uint16_value=7, string_value=text))
        numbers = (True, 0, 0, 0.0, 0.0, 0, 0, 0, 7, 0, 0, 0, 0, length + 1)
        body = struct.pack("<?BBxfdbBhH2xiIqQI", *numbers) + text.encode() + b"\0"
        assert bytes(asked(app).body) == CDR_ENCAPSULATION + body


def test_padding_of_any_bytes_becomes_zeros_and_what_is_behind_is_cut_off() -> None:
    layout, _, _ = described_service("test_msgs/srv/BasicTypes").layout.partition(">")
    body = struct.pack("<?BBxfdbBhH2xiIqQI", True, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 2)
    dirty = bytearray(body)
    for at in (3, 22, 23):
        dirty[at] = 0xAA
    found = exact(CDR_ENCAPSULATION + bytes(dirty) + b"x\0behind", layout)
    assert found == CDR_ENCAPSULATION + body + b"x\0"


@pytest.mark.parametrize(
    ("kind", "body", "message"),
    [
        (Kind.FAILURE, Failure("refused", "it throws").to_bytes(), "refused: it throws"),
        (Kind.FAILURE, Failure("too_large", "70 KB").to_bytes(), "too_large: 70 KB"),
        (Kind.RESPONSE, CDR_ENCAPSULATION + b"\1\0\0\0\xff", "no response of std_srvs/srv/Trigger"),
        (None, b"", "did not answer within 10 s"),
    ],
)
def test_what_the_app_does_not_answer_fails_with_the_reason(
    kind: Kind | None, body: bytes, message: str, app: MockDevice, node: Node
) -> None:
    app.open(service())
    stop = client(node)
    future = stop.call_async(Trigger.Request())
    request = asked(app)
    if kind is not None:
        reply(app, request, kind, body)
    failed = result(future)
    assert not failed.success
    assert failed.message.startswith(f"{STOP}: ")
    assert message in failed.message
    reply(app, request, Kind.RESPONSE, response(True, "too late"))
    assert answered(app, stop, "in time") == "in time"


def test_16_requests_are_under_way_at_most(app: MockDevice, node: Node) -> None:
    app.open(service())
    stop = client(node)
    futures = [stop.call_async(Trigger.Request()) for _ in range(20)]
    requests = [asked(app) for _ in range(16)]
    await_true(lambda: sum(it.done() for it in futures) == 4)
    assert {it.result().message for it in futures if it.done()} == {
        f"{STOP}: 16 requests are under way, the most"
    }
    for number, request in enumerate(reversed(requests)):
        reply(app, request, Kind.RESPONSE, response(True, str(number)))
    texts = {result(it).message for it in futures if result(it).success}
    assert texts == {str(number) for number in range(16)}


def test_when_the_session_ends_requests_fail_and_the_next_session_answers_again(
    app: MockDevice, node: Node
) -> None:
    app.open(service())
    stop = client(node)
    futures = [stop.call_async(Trigger.Request()) for _ in range(3)]
    for _ in futures:
        asked(app)
    app.disconnect()
    assert [result(it).success for it in futures] == [False] * 3
    assert "was lost" in futures[0].result().message
    meanwhile = result(stop.call_async(Trigger.Request()))
    assert meanwhile.message == f"{STOP}: the headset is not connected"
    with MockDevice(app.address, instance_id="next", says_ping=True, has_ros=True) as back:
        back.start()
        assert back.open(service(2)).result == "opened"
        assert answered(back, stop, "back") == "back"


def test_what_the_app_has_closed_is_gone_after_a_while(app: MockDevice, node: Node) -> None:
    app.open(service())
    stop = client(node)
    app.wires["control"].send(Kind.CLOSE, Close(1))
    app.wires["control"].expect(Kind.CLOSED)
    assert not result(stop.call_async(Trigger.Request())).success
    await_true(lambda: not stop.service_is_ready())


def test_a_type_that_cannot_fail_is_gone_with_its_session(app: MockDevice, node: Node) -> None:
    app.open(service(type=NOTHING))
    stop = client(node, Empty)
    stop.call_async(Empty.Request())
    asked(app)
    app.disconnect()
    await_true(lambda: not stop.service_is_ready())


def test_a_type_that_cannot_fail_is_offered_anew_after_a_failure(
    app: MockDevice, node: Node
) -> None:
    app.open(service(type=NOTHING))
    stop = client(node, Empty)
    lost = stop.call_async(Empty.Request())
    reply(app, asked(app), Kind.FAILURE, Failure("refused", "it throws").to_bytes())
    # A request to the service that is gone is lost
    futures = [stop.call_async(Empty.Request())]
    node.create_timer(0.1, lambda: futures.append(stop.call_async(Empty.Request())))
    # A response is lost, too, while the new service does not know the client
    while not any(it.done() for it in futures):
        reply(app, asked(app), Kind.RESPONSE, EMPTY)
    assert not lost.done()


def test_the_type_of_a_service_that_is_left_may_change(app: MockDevice, node: Node) -> None:
    app.open(service())
    with tool_node("before") as before, answering(before):
        client(before)
    app.wires["control"].send(Kind.CLOSE, Close(1))
    app.wires["control"].expect(Kind.CLOSED)
    assert app.open(service(2, type=SET_BOOL)).result == "opened"
    future = client(node, SetBool).call_async(SetBool.Request(data=True))
    request = asked(app)
    assert bytes(request.body) == TRUE
    reply(app, request, Kind.RESPONSE, response(True, ""))
    assert result(future).success


@pytest.mark.parametrize(
    ("wanted", "code", "names"),
    [
        (service(name="/robot/start"), "rules", ["app.offer", "/robot/start"]),
        (service(type="no_srvs/srv/Such"), "type", ["no_srvs/srv/Such"]),
        (service(name="no name"), "name", ["no name"]),
        (service(layout="b>bs"), "layout", ["b>bs", "1>bs"]),
        (service(name="custom/on"), None, ["the app offers /magic_leap2/custom/on already"]),
        (service(name="/robot/stop", type=NOTHING), "type", [NOTHING, TRIGGER]),
    ],
)
def test_a_service_that_is_not_opened_is_refused_with_the_reason(
    wanted: Open, code: str | None, names: list[str], app: MockDevice, node: Node
) -> None:
    node.create_service(Trigger, "/robot/stop", lambda _, it: it)
    app.open(service(9, "custom/on"))
    client(node, name="/robot/stop")
    client(node, name="/magic_leap2/custom/on")
    opened = app.open(wanted)
    assert (opened.result, opened.code) == ("refused", code)
    assert [it for it in names if it not in str(opened.reason)] == []
