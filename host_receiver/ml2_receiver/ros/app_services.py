"""Offers services of apps in ROS, so that each request has one answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message

from ..session.downlink import Downlink
from ..session.graph import in_words
from ..wire.frame import Header
from ..wire.kinds import Kind
from ..wire.opening_bodies import Failure
from .app_clients import AppServing
from .layout import Described, exact

_NANOS_PER_SECOND = 1_000_000_000
# The app has this long for an answer.
_ANSWER_S = 10.0
_MOST_REQUESTS = 16
_QOS = QoSProfile(depth=100)


@dataclass(frozen=True)
class _Asked:
    header: Any
    due_s: float


class AppService(AppServing):
    """A service of an app.

    A request without an answer of the app gets `success=False` and the reason, also while the app
    has left it. A type without `success` cannot say so: its service is made anew, so that clients
    see that it was gone.

    Args:
        numbers: the numbers of requests, of all services.
    """

    kind: Literal["service"] = "service"

    def __init__(
        self,
        topic: str,
        own: Described,
        is_over: Callable[[AppServing], None],
        numbers: Iterator[int],
    ) -> None:
        super().__init__(topic, own, is_over)
        fields = self._class.Response.get_fields_and_field_types()
        self._can_fail = fields.get("success") == "boolean"
        self._has_message = fields.get("message") == "string"
        self._numbers = numbers
        self._asked: dict[int, _Asked] = {}
        self._node: Node | None = None
        self._service: Any = None

    @property
    def handle(self) -> Any:
        return self._service.handle

    def begin(self, node: Node) -> None:
        self._node = node
        self._change()
        self._service = node.create_service(
            self._class, self.topic, lambda _, answer: answer, qos_profile=_QOS
        )

    def end(self, node: Node) -> None:
        if self._service is None:
            return
        self._change()
        self._leave()
        self._take()
        node.destroy_service(self._service)

    def _received(self, header: Header, body: bytes) -> None:
        if header.kind == Kind.RESPONSE:
            self._answer(header.sequence, body)
        else:
            failure = Failure.parse(body)
            self._fail(header.sequence, f"{failure.code}: {failure.message}")

    def _look(self, now_s: float) -> None:
        for number, asked in list(self._asked.items()):
            if now_s > asked.due_s:
                self._fail(number, f"the app did not answer within {_ANSWER_S:g} s")

    def _leave(self) -> None:
        super()._leave()
        if not self._can_fail:
            self._left_s = 0.0
        for number in list(self._asked):
            self._fail(number, "the connection to the headset was lost, or its app has ended this")

    def _take(self) -> None:
        while True:
            request, header = self.handle.service_take_request(self._class.Request)
            if header is None:
                return
            number = next(self._numbers)
            self._asked[number] = _Asked(header, time.monotonic() + _ANSWER_S)
            if self._app is None:
                self._fail(number, "the headset is not connected")
            elif len(self._asked) > _MOST_REQUESTS:
                self._fail(number, f"{_MOST_REQUESTS} requests are under way, the most")
            else:
                self._ask(number, request, *self._app)

    def _ask(self, number: int, request: Any, id: int, downlink: Downlink) -> None:
        body = exact(serialize_message(request), self._request_layout)
        if len(body) > (most := Kind.REQUEST.max_length):
            self._fail(number, f"a request of {len(body)} bytes, at most {most}")
        else:
            limit_ns = int(_ANSWER_S * _NANOS_PER_SECOND)
            downlink.send(Kind.REQUEST, id, number, body, limit_ns)

    def _answer(self, number: int, body: bytes) -> None:
        if number not in self._asked:
            return
        try:
            payload = exact(body, self._response_layout)
            response = deserialize_message(payload, self._class.Response)
        except Exception as error:  # of several types
            self._fail(number, f"the app answers no response of {self.type}: {error}")
        else:
            self._send(number, response)

    def _fail(self, number: int, why: str) -> None:
        if number not in self._asked:
            return
        if not self._can_fail:
            self._begin_anew()
            return
        response = self._class.Response()
        response.success = False
        if self._has_message:
            response.message = in_words(f"{self.topic}: {why}")
        self._send(number, response)

    def _send(self, number: int, response: Any) -> None:
        asked = self._asked.pop(number)
        self.handle.service_send_response(response, asked.header.request_id)

    def _begin_anew(self) -> None:
        assert self._node is not None
        self._asked.clear()
        self._node.destroy_service(self._service)
        self.begin(self._node)
