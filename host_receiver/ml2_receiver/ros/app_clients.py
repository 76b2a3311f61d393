"""Calls services of ROS for apps, so that each request has one answer."""

from __future__ import annotations

import queue
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message

from ..session.downlink import Downlink
from ..session.graph import in_words
from ..topics.message_types import service_class
from ..wire.frame import Frame
from ..wire.kinds import Kind
from ..wire.opening_bodies import Failure
from .layout import Described, exact

_NANOS_PER_SECOND = 1_000_000_000
# All that may be under way, so that ROS keeps what a slow server has not acknowledged.
_QOS = QoSProfile(depth=64)
# How long a new client looks for the service before it says that there is none.
_SEARCH_S = 1.0


@dataclass(eq=False)
class _Call:
    number: int
    request: Any
    due_s: float
    sequence: int | None = None


class AppClient:
    """A client of an app, Serving. Any thread may call put(); the rest is the taker's.

    A request whose service is not there is answered at once, but for the first second of the
    client, since ROS finds services late.
    """

    kind: Literal["client"] = "client"

    def __init__(self, id: int, topic: str, own: Described, downlink: Downlink) -> None:
        self.id, self.topic = id, topic
        self._own, self._downlink = own, downlink
        self._type = service_class(own.type)
        self._request_layout, _, self._response_layout = own.layout.partition(">")
        self._new: queue.SimpleQueue[_Call] = queue.SimpleQueue()
        self._calls: list[_Call] = []
        self._began_s = time.monotonic()
        self._client: Any = None

    @property
    def handle(self) -> Any:
        return self._client.handle

    def put(self, frame: Frame) -> None:
        """Takes a REQUEST, whose body is valid during the call alone."""
        number, limit_s = frame.header.sequence, frame.header.capture_ns / _NANOS_PER_SECOND
        try:
            payload = exact(bytes(frame.body), self._request_layout)
            request = deserialize_message(payload, self._type.Request)
        except Exception as error:  # of several types
            self._fail(number, "malformed", f"no request of {self._own.type}: {error}")
        else:
            self._new.put(_Call(number, request, time.monotonic() + limit_s))

    def failed(self, error: Exception) -> None:
        """Ends the client, since ROS does not make it, or not read an answer."""
        self._downlink.end(self.id, in_words(f"{self.topic}: {error}"), "type")

    def begin(self, node: Node) -> None:
        self._client = node.create_client(self._type, self.topic, qos_profile=_QOS)

    def end(self, node: Node) -> None:
        node.destroy_client(self._client)

    def work(self, *, is_ready: bool) -> None:
        with suppress(queue.Empty):
            while True:
                self._calls.append(self._new.get_nowait())
        if is_ready:
            self._take()
        if not self._calls:
            return
        is_there, now_s = self._client.service_is_ready(), time.monotonic()
        is_searched = now_s > self._began_s + _SEARCH_S
        for call in list(self._calls):
            if not is_there and (is_searched or now_s > call.due_s):
                self._end(call, "unavailable", f"no node offers {self.topic} now")
            elif now_s > call.due_s:
                self._end(call, "timeout", f"{self.topic} did not answer in time")
            elif is_there and call.sequence is None:
                self._ask(call)

    def _ask(self, call: _Call) -> None:
        try:
            call.sequence = self.handle.send_request(call.request)
        except Exception as error:  # of several types
            self._end(call, "malformed", f"ROS does not take the request: {error}")

    def _take(self) -> None:
        asked = {it.sequence: it for it in self._calls if it.sequence is not None}
        while True:
            header, response = self.handle.take_response(self._type.Response)
            if header is None:
                return
            # None of one whose time was over
            if (call := asked.get(header.request_id.sequence_number)) is not None:
                self._answer(call, response)

    def _answer(self, call: _Call, response: Any) -> None:
        body = exact(serialize_message(response), self._response_layout)
        if len(body) > (most := Kind.RESPONSE.max_length):
            self._end(call, "too_large", f"{self.topic} answers {len(body)} bytes, at most {most}")
        else:
            self._calls.remove(call)
            self._downlink.send(Kind.RESPONSE, self.id, call.number, body)

    def _end(self, call: _Call, code: str, why: str) -> None:
        self._calls.remove(call)
        self._fail(call.number, code, why)

    def _fail(self, number: int, code: str, why: str) -> None:
        body = Failure(code, in_words(why)).to_bytes()
        self._downlink.send(Kind.FAILURE, self.id, number, body)
