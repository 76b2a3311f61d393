"""Calls services of ROS for apps, so that each request has one answer."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message

from ..session.downlink import Downlink
from ..session.graph import in_words
from ..topics.message_types import service_class
from ..wire.frame import Frame, Header
from ..wire.kinds import Kind
from ..wire.opening_bodies import Failure
from .layout import Described, exact

_NANOS_PER_SECOND = 1_000_000_000
# All that may be under way, so that ROS keeps what a slow server has not acknowledged.
_QOS = QoSProfile(depth=64)
# A new client looks for its service for this long before it reports that there is none.
_SEARCH_S = 1.0
# A client or service that the app has left is kept for this long: most links are back by then.
_LEFT_S = 10.0


class AppServing:
    """A client or a service of an app, Serving, over all its sessions.

    Any thread may call resume(), leave() and put(); the rest is the taker's. ROS takes some time to
    know a new one, and meanwhile loses answers, so one that the app has left is kept for a while.

    Args:
        is_over: is told, again and again, that the app has left it for long.

    Attributes:
        has_failed: True if ROS does not make it, or not take its messages.
    """

    def __init__(self, topic: str, own: Described, is_over: Callable[[AppServing], None]) -> None:
        self.topic, self.type = topic, own.type
        self.has_failed = False
        self._class = service_class(own.type)
        self._request_layout, _, self._response_layout = own.layout.partition(">")
        self._is_over = is_over
        self._changes: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._app: tuple[int, Downlink] | None = None
        self._left_s = 0.0

    def resume(self, id: int, downlink: Downlink) -> None:
        """Begins the opening `id` of an app."""
        self._changes.put(partial(self._resume, id, downlink))

    def leave(self) -> None:
        """Ends the opening."""
        self._changes.put(self._leave)

    def put(self, frame: Frame) -> None:
        """Takes a frame of the app, whose body is valid during the call alone."""
        self._changes.put(partial(self._received, frame.header, bytes(frame.body)))

    def failed(self, error: Exception) -> None:
        """Ends the opening, since ROS does not make it, or not take its messages."""
        self.has_failed = True
        if self._app is not None:
            id, downlink = self._app
            downlink.end(id, in_words(f"{self.topic}: {error}"), "type")

    def work(self, *, is_ready: bool) -> None:
        self._change()
        if is_ready:
            self._take()
        now_s = time.monotonic()
        self._look(now_s)
        if self._app is None and now_s > self._left_s:
            self._is_over(self)

    def _change(self) -> None:
        with suppress(queue.Empty):
            while True:
                self._changes.get_nowait()()

    def _resume(self, id: int, downlink: Downlink) -> None:
        self._leave()
        self._app = id, downlink

    def _leave(self) -> None:
        self._app, self._left_s = None, time.monotonic() + _LEFT_S

    def _received(self, header: Header, body: bytes) -> None:
        raise NotImplementedError

    def _take(self) -> None:
        raise NotImplementedError

    def _look(self, now_s: float) -> None:
        raise NotImplementedError


@dataclass(eq=False)
class _Call:
    number: int
    request: Any
    due_s: float
    sequence: int | None = None


class AppClient(AppServing):
    """A client of an app.

    A request whose service is not there is answered at once, but for the first second of the
    client, since ROS finds services late.
    """

    kind: Literal["client"] = "client"

    def __init__(self, topic: str, own: Described, is_over: Callable[[AppServing], None]) -> None:
        super().__init__(topic, own, is_over)
        self._calls: list[_Call] = []
        self._began_s = time.monotonic()
        self._client: Any = None

    @property
    def handle(self) -> Any:
        return self._client.handle

    def begin(self, node: Node) -> None:
        self._client = node.create_client(self._class, self.topic, qos_profile=_QOS)

    def end(self, node: Node) -> None:
        if self._client is not None:
            node.destroy_client(self._client)

    def _received(self, header: Header, body: bytes) -> None:
        limit_s = header.capture_ns / _NANOS_PER_SECOND
        try:
            payload = exact(body, self._request_layout)
            request = deserialize_message(payload, self._class.Request)
        except Exception as error:  # of several types
            self._fail(header.sequence, "malformed", f"no request of {self.type}: {error}")
        else:
            self._calls.append(_Call(header.sequence, request, time.monotonic() + limit_s))

    def _leave(self) -> None:
        super()._leave()
        self._calls.clear()

    def _look(self, now_s: float) -> None:
        if not self._calls:
            return
        is_there = self._client.service_is_ready()
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
            header, response = self.handle.take_response(self._class.Response)
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
            self._send(Kind.RESPONSE, call.number, body)

    def _end(self, call: _Call, code: str, why: str) -> None:
        self._calls.remove(call)
        self._fail(call.number, code, why)

    def _fail(self, number: int, code: str, why: str) -> None:
        self._send(Kind.FAILURE, number, Failure(code, in_words(why)).to_bytes())

    def _send(self, kind: Kind, number: int, body: bytes) -> None:
        if self._app is not None:
            id, downlink = self._app
            downlink.send(kind, id, number, body)
