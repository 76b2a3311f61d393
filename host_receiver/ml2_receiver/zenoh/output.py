"""Keeps a session with a router, and publishes there."""

import json
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Literal, Self

import zenoh

from ..errors import PublishError
from ..table.stream_table import StreamTable
from ..topics.control import ReceiverControl
from ..topics.diagnostics import Diagnostics, security_row
from ..topics.fan_out import FanOut
from ..topics.plain_messages import encode_statuses
from .names import NODE_NAME
from .sink import ZenohSink
from .unreachable import why_unreachable

_PERIOD_S = 1.0  # of /diagnostics, and of attempts to connect

type _News = Literal["demand", "router", "close"]


@dataclass(frozen=True)
class Identity:
    """Names that identify this receiver in messages and topics.

    Attributes:
        receiver: as in --name, may be empty.
        prefix: of the relative topics.
        domain: the ROS domain id.
        remapped: returns the name of a topic after the remappings of ROS's arguments.
        node: its name after them.
    """

    receiver: str
    prefix: str
    domain: int
    remapped: Callable[[str], str] = str
    node: str = NODE_NAME


class ZenohOutput:
    """Adds a ZenohSink to `sinks` as soon as the router answers, and /diagnostics once a second.

    A thread tries to connect until it succeeds; later Zenoh does so itself. Events say what is not
    reachable and why, and what is connected. It runs while it is entered.

    Args:
        config: of the session.
        endpoint: the router in it.
        control: what runs the streams; is told which ones have subscribers.
    """

    def __init__(
        self,
        config: zenoh.Config,
        endpoint: str,
        identity: Identity,
        table: StreamTable,
        sinks: FanOut,
        control: ReceiverControl,
    ) -> None:
        self._config, self._endpoint, self._identity = config, endpoint, identity
        self._table, self._sinks, self._control = table, sinks, control
        self._diagnostics = Diagnostics(identity.prefix)
        self._news: SimpleQueue[_News] = SimpleQueue()
        self._router = endpoint.partition("#")[0]  # what follows may hold a key
        self._said = ""
        self._is_connected: bool | None = None
        self._thread = threading.Thread(target=self._run, name="zenoh")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Ends the topics and the session; blocks for 4 s at most while there is no router."""
        self._news.put("close")
        self._thread.join()

    def _run(self) -> None:
        session = self._session()
        if session is None:
            return
        with session:
            sink = self._new_sink(session)
            self._sinks.add(sink)
            # From here on, since those before are known.
            listener = session.info.declare_transport_events_listener(
                lambda _: self._news.put("router")
            )
            self._say_connection(session)
            self._handle_news(session, sink)
            listener.undeclare()
            self._sinks.remove(sink)
            self._control.demand("zenoh", {})
            sink.close()

    def _session(self) -> zenoh.Session | None:
        """Returns a session, or None after close()."""
        while True:
            try:
                return zenoh.open(self._config)
            except zenoh.ZError:
                self._say_unreachable()
            if self._next(_PERIOD_S) == "close":
                return None

    def _new_sink(self, session: zenoh.Session) -> ZenohSink:
        mine = self._identity
        return ZenohSink(
            session,
            self._table,
            mine.prefix,
            mine.receiver,
            mine.domain,
            lambda: self._news.put("demand"),
            mine.remapped,
            mine.node,
        )

    def _handle_news(self, session: zenoh.Session, sink: ZenohSink) -> None:
        due_s = time.monotonic()
        while (news := self._next(due_s - time.monotonic())) != "close":
            if news == "demand":
                self._control.demand("zenoh", sink.demand())
            is_due = time.monotonic() >= due_s
            if news == "router" or is_due:  # news may come before Zenoh has forgotten the router
                self._say_connection(session)
            if is_due:
                due_s += _PERIOD_S
                self._report(sink)

    def _next(self, timeout_s: float) -> _News | None:
        with suppress(Empty):
            return self._news.get(timeout=max(0.0, timeout_s))
        return None

    def _say_connection(self, session: zenoh.Session) -> None:
        is_connected = bool(session.info.routers_zid() or session.info.peers_zid())
        if is_connected == self._is_connected:
            return
        self._is_connected = is_connected
        if is_connected:
            self._say(f"Zenoh: connected to {self._router}")
        else:
            self._say_unreachable()

    def _say_unreachable(self) -> None:
        tls = json.loads(self._config.get_json("transport/link/tls"))
        reason = why_unreachable(self._endpoint, tls)
        self._say(f"Zenoh: {self._router} is not reached: {reason}; trying again")

    def _say(self, text: str) -> None:
        if text != self._said:
            self._said = text
            self._sinks.event(text)

    def _report(self, sink: ZenohSink) -> None:
        rows = self._diagnostics.rows(self._control.report(), time.monotonic())
        rows.append(security_row(self._control.paired()))
        more = {name: {"zenoh_published": str(it)} for name, it in sink.published().items()}
        with suppress(PublishError):  # the session has ended, which its own event says
            sink.diagnose(encode_statuses(self._identity.receiver, rows, more, time.time_ns()))
