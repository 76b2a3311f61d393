"""The receiver as a state machine without I/O: who is connected, and whose turn it is."""

from collections import Counter
from collections.abc import Callable

from ..errors import ErrorCode, LinkTestError, ProtocolError
from ..wire.frame import VERSION, Frame, Kind
from ..wire.messages import Bye, Hello, Join
from .connection import Connection
from .context import Close, Context, Ending, Send, close, error_body
from .event_limit import EventLimit, OncePerAddress
from .report import State
from .session import Session
from .statistics import Instance
from .streams import DesiredStreams, Request


class Host:
    """Connections of one or many peers and the one session.

    Tell it what happens: opened(), received(), failed(), closed(), and tick() a few times per
    second. What it wants done goes to Context.act. Calls must not overlap.

    Args:
        request: what every headset is asked for, until request() changes it.
        is_paused: START waits for begin().
    """

    def __init__(self, context: Context, request: Request, *, is_paused: bool = False) -> None:
        self.session: Session | None = None
        self._context = context
        self._request = request
        self._is_paused = is_paused
        self._pending: list[Connection] = []
        self._is_settled = False
        self._successor: tuple[Connection, Hello] | None = None
        self._refusals = EventLimit(context.sink.event, context.clock, per_second=10)
        self._busy = OncePerAddress(self._refusals.say)
        self._events = EventLimit(context.sink.event, context.clock, per_second=100)

    def opened(self, connection: Connection) -> None:
        """A peer has connected.

        If too many connections are pending, one of them is closed.
        """
        if len(self._pending) >= self._context.settings.limits.unfinished_connections:
            oldest = self._dispensable()
            self._pending.remove(oldest)
            self._say(oldest, "closed for a newer connection")
            oldest.is_closing = True
            self._context.act(Close(oldest, Ending.ABORT))
        self._pending.append(connection)

    def _dispensable(self) -> Connection:
        """Returns the oldest connection of the address that has most of them."""
        counts = Counter(each.host for each in self._pending)
        return max(self._pending, key=lambda each: counts[each.host])

    def received(self, connection: Connection, frame: Frame) -> None:
        """A frame other than DATA and TIME_REQUEST arrived."""
        if connection.is_closing:
            return
        try:
            if connection.lane is None:
                self._greeted(connection, frame)
            elif self.session is not None and connection in self.session:
                self.session.received(connection, frame)
                self.update()
                self._settle()
        except ProtocolError as error:
            self.failed(connection, error, is_told=frame.header.kind != Kind.ERROR)

    def _greeted(self, connection: Connection, frame: Frame) -> None:
        match frame.header.kind:
            case Kind.HELLO:
                self._hello(connection, Hello.parse(frame.payload))
            case Kind.JOIN:
                self._join(connection, Join.parse(frame.payload))
            case _:  # only ERROR gets here, and it is not answered
                self._say(connection, "ERROR instead of HELLO or JOIN")
                close(self._context, connection, Ending.DRAIN)

    def _hello(self, connection: Connection, hello: Hello) -> None:
        if VERSION not in hello.versions:
            raise ProtocolError(
                ErrorCode.VERSION, f"this receiver speaks {VERSION}, not {hello.versions[:8]}"
            )
        present = self._present()
        if present is not None and self._identity(*present) != self._identity(connection, hello):
            raise ProtocolError(ErrorCode.BUSY, f"{present[1].name!r} is connected")
        if self._successor is not None:
            raise ProtocolError(ErrorCode.BUSY, "another connection of this device was faster")
        self._pending.remove(connection)
        self._successor = connection, hello
        if self.session is not None:
            self.session.finish(State.LOST, "replaced by a new one", Bye("replaced"))
        self._settle()

    def _present(self) -> tuple[Connection, Hello] | None:
        if self._successor is not None or self.session is None or self.session.is_over:
            return self._successor
        return self.session.control, self.session.hello

    @staticmethod
    def _identity(connection: Connection, hello: Hello) -> tuple[str | None, str]:
        return connection.peer, hello.device_id

    def _settle(self) -> None:
        """Reports a session that is over, and begins the one that waited for that."""
        if self.session is not None:
            if not self.session.is_over:
                return
            if not self._is_settled:
                self._is_settled = True
                self._busy.renew()
                self._context.sink.session_ended(self.session.report())
        if self._successor is not None:
            self._begin(*self._successor)

    def _begin(self, control: Connection, hello: Hello) -> None:
        self._successor = None
        self._is_settled = False
        self._busy.renew()
        instance = Instance(hello.device_id, hello.instance_id)
        is_known = self.session is not None and self.session.instance == instance
        if self.session is not None and is_known:
            instance = self.session.instance
        self._events.say(
            f"{hello.name!r} connected from {control.address}, running {hello.software!r}"
        )
        self.session = Session(hello, control, instance, self._context, self._events.say)
        self.session.welcome(instance.received() if is_known else None)

    def _join(self, connection: Connection, join: Join) -> None:
        if self.session is None:
            raise ProtocolError(ErrorCode.TICKET, "there is no session")
        self.session.join(connection, join)
        self._pending.remove(connection)
        self.update()

    def failed(self, connection: Connection, error: ProtocolError, *, is_told: bool = True) -> None:
        """A connection broke the protocol: it is told, and its session ends."""
        if connection.is_closing:
            return
        if error.code == ErrorCode.BUSY and is_told:
            self._busy.say(connection.host, str(error))
        else:
            self._say(connection, str(error))
        if is_told:
            self._context.act(Send(connection, Kind.ERROR, error_body(error)))
        close(self._context, connection, Ending.DISCARD)
        if self.session is not None and connection in self.session:
            self.session.finish(State.LOST, str(error))

    def refusal(self, connection: Connection, channel: int) -> ProtocolError:
        """Why DATA of a channel that its connection has no route for is wrong."""
        if self.session is None or connection not in self.session:
            return ProtocolError(ErrorCode.UNEXPECTED, "DATA outside of a session")
        return self.session.streams.data_error(channel)

    def closed(self, connection: Connection, fault: str | None = None) -> None:
        """A connection has ended and nothing of it is being read any more.

        `fault` says what ended it, None if that was the peer, between two frames.
        """
        if connection in self._pending:
            self._pending.remove(connection)
            if not connection.is_closing:
                self._say(connection, fault or "ended without HELLO or JOIN")
        if self._successor is not None and self._successor[0] is connection:
            self._successor = None
        if self.session is not None and connection in self.session:
            self.session.closed(connection, fault)
        self._settle()

    def tick(self) -> None:
        """Some time has passed."""
        handshake_s = self._context.settings.limits.handshake_s
        latest_s = self._context.clock() - handshake_s
        for pending in [each for each in self._pending if each.opened_s < latest_s]:
            message = f"no HELLO or JOIN within {handshake_s} s"
            self.failed(pending, ProtocolError(ErrorCode.TIMEOUT, message))
        if self.session is not None:
            self.session.tick()
        self._settle()

    def request(self, request: Request) -> None:
        """Asks for other streams or values; streams whose values stay go on undisturbed."""
        self._request = request
        self.update()

    def begin(self) -> None:
        """Lets the streams run, now or as soon as a headset is ready for it."""
        self._is_paused = False
        self.update()

    def pause(self) -> None:
        """Stops all streams until begin(); the headset stays connected."""
        self._is_paused = True
        self.update()

    def test_link(self) -> None:
        """Tries what the link to the headset carries; the session's report has the result.

        Raises:
            LinkTestError: no headset is connected, or it is being asked already.
        """
        if self.session is None:
            raise LinkTestError("no headset is connected")
        self.session.test_link()

    def update(self) -> None:
        """Tells the headset when what is wanted of it, Context.idle included, has changed."""
        if self.session is not None:
            idle, excluded = self._context.idle(), self._context.settings.excluded
            self.session.advance(DesiredStreams(self._request, self._is_paused, idle, excluded))

    def expel(self, is_allowed: Callable[[str | None], bool]) -> None:
        """Ends what there is of peers that are not allowed any more."""
        for pending in [each for each in self._pending if each.peer is not None]:
            if not is_allowed(pending.peer):
                self.failed(pending, ProtocolError(ErrorCode.PAIRING, "it is not paired"))
        if self._successor is not None and not is_allowed(self._successor[0].peer):
            close(self._context, self._successor[0], Ending.ABORT)
            self._successor = None
        if self.session is not None and not is_allowed(self.session.control.peer):
            self.session.finish(State.ENDED, "the device was unpaired", Bye("unpaired"))
        self._settle()

    def stop(self) -> None:
        """Says goodbye to everybody."""
        if self.session is not None:
            self.session.finish(State.ENDED, "the receiver stops", Bye("the receiver stops"))
        for pending in self._pending:
            close(self._context, pending, Ending.ABORT)

    def _say(self, connection: Connection, text: str) -> None:
        lane = connection.lane or "new connection"
        self._refusals.say(f"{connection.address} ({lane}): {text}")
