"""The receiver as a state machine without I/O: its connections and its one session."""

import math
from collections import Counter, deque
from collections.abc import Callable

from ..errors import ErrorCode, LinkTestError, ProtocolError
from ..wire.frame import VERSION, Frame
from ..wire.kinds import Kind
from ..wire.messages import Bye, Hello, Join
from .actions import Action, Close, Ending, Log, Open, Send, SessionEnded, close, error_body
from .connection import Connection
from .event_limit import OncePerAddress
from .report import State
from .session import Session
from .settings import ReceiverSettings
from .statistics import Instance
from .streams import DesiredStreams

# A peer of another version comes again and again; this often it is worth a line.
_INCOMPATIBLE_S = 60.0
# A busy machine ticks so late; one that is later has stood still.
_LATE_S = 1.0


class Host:
    """The connections of all peers, and the one session.

    Call opened(), received(), failed() and closed() when a connection changes, update() after a
    frame or when the desired streams may have changed, and tick() a few times per second. Then take
    and perform `actions`, in any thread and in their order. `now_s` is monotonic time. Calls must
    not overlap.
    """

    def __init__(self, settings: ReceiverSettings) -> None:
        self.session: Session | None = None
        self.actions: deque[Action] = deque()
        self._act = self.actions.append
        self._settings = settings
        self._pending: list[Connection] = []
        self._is_reported = False
        self._successor: tuple[Connection, Hello] | None = None
        self._busy = OncePerAddress(lambda text: self._act(Log(text, "refusal")))
        self._incompatible = OncePerAddress(lambda text: self._act(Log(text, "refusal")))
        self._said_since_s = 0.0
        self._ticked_s = math.inf

    def opened(self, connection: Connection) -> None:
        """Adds a connection; closes a pending one if there are too many."""
        if len(self._pending) >= self._settings.limits.unfinished_connections:
            oldest = self._oldest_of_busiest_address()
            self._pending.remove(oldest)
            self._log_refusal(oldest, "closed for a newer connection")
            oldest.is_closing = True
            self._act(Close(oldest, Ending.ABORT))
        self._pending.append(connection)

    def _oldest_of_busiest_address(self) -> Connection:
        """Returns the oldest pending connection of the address that has most of them."""
        counts = Counter(each.host for each in self._pending)
        return max(self._pending, key=lambda each: counts[each.host])

    def received(self, connection: Connection, frame: Frame, now_s: float) -> None:
        """Handles a frame other than DATA and TIME_REQUEST."""
        if connection.is_closing:
            return
        try:
            if connection.lane is None:
                self._first_frame(connection, frame, now_s)
            elif self.session is not None and connection in self.session:
                self.session.received(connection, frame, now_s)
                self._replace_ended_session(now_s)
        except ProtocolError as error:
            self.failed(connection, error, sends_error=frame.header.kind != Kind.ERROR)

    def _first_frame(self, connection: Connection, frame: Frame, now_s: float) -> None:
        match frame.header.kind:
            case Kind.HELLO:
                self._hello(connection, Hello.parse(frame.body), now_s)
            case Kind.JOIN:
                self._join(connection, Join.parse(frame.body))
            case _:  # the parser lets only ERROR through, which needs no answer
                self._log_refusal(connection, "ERROR instead of HELLO or JOIN")
                close(self._act, connection, Ending.DRAIN)

    def _hello(self, connection: Connection, hello: Hello, now_s: float) -> None:
        if VERSION not in hello.versions:
            raise ProtocolError(
                ErrorCode.VERSION, f"this receiver speaks {VERSION}, not {hello.versions[:8]}"
            )
        current = self._current_device()
        if current is not None and self._identity(*current) != self._identity(connection, hello):
            raise ProtocolError(ErrorCode.BUSY, f"{current[1].name!r} is connected")
        if self._successor is not None:
            raise ProtocolError(ErrorCode.BUSY, "another connection of this device was faster")
        self._pending.remove(connection)
        self._successor = connection, hello
        if self.session is not None:
            self.session.finish(State.LOST, "replaced by a new one", Bye("replaced"))
        self._replace_ended_session(now_s)

    def _current_device(self) -> tuple[Connection, Hello] | None:
        if self._successor is not None or self.session is None or self.session.is_over:
            return self._successor
        return self.session.control, self.session.hello

    @staticmethod
    def _identity(connection: Connection, hello: Hello) -> tuple[str | None, str]:
        return connection.peer, hello.device_id

    def _replace_ended_session(self, now_s: float) -> None:
        """Reports a session that is over, and begins the session of the waiting device."""
        if self.session is not None:
            if not self.session.is_over:
                return
            if not self._is_reported:
                self._is_reported = True
                self._busy.renew()
                self._act(SessionEnded(self.session.report(now_s)))
        if self._successor is not None:
            self._begin(*self._successor, now_s)

    def _begin(self, control: Connection, hello: Hello, now_s: float) -> None:
        self._successor = None
        self._is_reported = False
        self._busy.renew()
        instance = Instance(hello.device_id, hello.instance_id, hello.channels or {})
        received = None
        if self.session is not None and self.session.instance == instance:
            instance = self.session.instance
            received = instance.received()
        text = f"{hello.name!r} connected from {control.address}, running {hello.software!r}"
        self._act(Log(text, "session"))
        self.session = Session(hello, control, instance, received, self._settings, self._act, now_s)

    def _join(self, connection: Connection, join: Join) -> None:
        if self.session is None:
            raise ProtocolError(ErrorCode.TICKET, "there is no session")
        self.session.join(connection, join)
        self._pending.remove(connection)

    def failed(
        self, connection: Connection, error: ProtocolError, *, sends_error: bool = True
    ) -> None:
        """Ends a connection that broke the protocol, and its session.

        The peer gets an ERROR unless `sends_error` is False.
        """
        if connection.is_closing:
            return
        if error.code == ErrorCode.BUSY and sends_error:
            self._busy.say(connection.host, str(error))
        elif error.code == ErrorCode.VERSION:
            self._incompatible.say(connection.host, str(error))
        else:
            self._log_refusal(connection, str(error))
        if sends_error:
            self._act(Send(connection, Kind.ERROR, error_body(error)))
        close(self._act, connection, Ending.DISCARD)
        if self.session is not None and connection in self.session:
            self.session.finish(State.LOST, str(error))

    def refusal(self, connection: Connection, channel: int) -> ProtocolError:
        """Returns the error for DATA of a channel that has no route on its connection."""
        if self.session is None or connection not in self.session:
            return ProtocolError(ErrorCode.UNEXPECTED, "DATA outside of a session")
        return self.session.streams.data_error(channel)

    def closed(self, connection: Connection, fault: str | None, now_s: float) -> None:
        """Removes a connection that has ended and is read to its end.

        `fault` says what ended it; None means that the peer did, between two frames.
        """
        if connection in self._pending:
            self._pending.remove(connection)
            if not connection.is_closing:
                self._log_refusal(connection, fault or "ended without HELLO or JOIN")
        if self._successor is not None and self._successor[0] is connection:
            self._successor = None
        if self.session is not None and connection in self.session:
            self.session.closed(connection, fault, now_s)
        self._replace_ended_session(now_s)

    def tick(self, now_s: float) -> None:
        """Checks the time-outs of the pending connections and of the session.

        Time in which nobody ticked, since the machine stood still, is not the headset's silence.
        """
        stood_still_s = max(0.0, now_s - self._ticked_s - _LATE_S)
        self._ticked_s = now_s
        if now_s - self._said_since_s > _INCOMPATIBLE_S:
            self._incompatible.renew()
            self._said_since_s = now_s
        handshake_s = self._settings.limits.handshake_s
        for pending in [it for it in self._pending if it.opened_s < now_s - handshake_s]:
            message = f"no HELLO or JOIN within {handshake_s} s"
            self.failed(pending, ProtocolError(ErrorCode.TIMEOUT, message))
        if self.session is not None:
            self.session.tick(now_s, stood_still_s)
        self._replace_ended_session(now_s)

    def topic_refused(self, opened: Open, reason: str, now_s: float) -> None:
        """Takes why the topic of an Open cannot be opened."""
        is_open = not opened.control.is_closing
        if is_open and self.session is not None and opened.control in self.session:
            self.session.topic_refused(opened.channel, reason, now_s)

    def update(self, desired: DesiredStreams, now_s: float) -> None:
        """Requests the desired streams from the headset if they have changed."""
        if self.session is not None:
            self.session.advance(desired, now_s)

    def test_link(self, now_s: float) -> None:
        """Starts a link test, as Session.test_link() does."""
        if self.session is None:
            raise LinkTestError("no headset is connected")
        self.session.test_link(now_s)

    def expel(self, is_allowed: Callable[[str | None], bool], now_s: float) -> None:
        """Ends the connections and the session of peers that are not allowed any more."""
        for pending in [each for each in self._pending if each.peer is not None]:
            if not is_allowed(pending.peer):
                self.failed(pending, ProtocolError(ErrorCode.PAIRING, "it is not paired"))
        if self._successor is not None and not is_allowed(self._successor[0].peer):
            close(self._act, self._successor[0], Ending.ABORT)
            self._successor = None
        if self.session is not None and not is_allowed(self.session.control.peer):
            self.session.finish(State.ENDED, "the device was unpaired", Bye("unpaired"))
        self._replace_ended_session(now_s)

    def stop(self) -> None:
        """Ends the session with BYE, and aborts the pending connections."""
        if self.session is not None:
            self.session.finish(State.ENDED, "the receiver stops", Bye("the receiver stops"))
        for pending in self._pending:
            close(self._act, pending, Ending.ABORT)

    def _log_refusal(self, connection: Connection, text: str) -> None:
        self._act(Log(f"{connection.address} ({connection.name}): {text}", "refusal"))
