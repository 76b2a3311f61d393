"""The threads of a receiver: a reader per connection, an acceptor and a timer."""

import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Collection

from ..errors import ErrorCode, KeysError, ProtocolError
from ..transport.access import Access, Protection
from ..wire.frame import Frame, encode_frame
from ..wire.kinds import Kind, LaneKind
from ..wire.messages import Link
from .acceptor import Acceptor
from .admission import Admission
from .connection import Connection
from .connection_io import ConnectionIO
from .context import Action, Close, Context, Send
from .event_limit import EventLimit
from .host import Host
from .report import Report
from .settings import ReceiverSettings
from .sink import Sink
from .streams import Request

_TICK_S = 0.1
_STOP_S = 0.3
_TIME = struct.Struct("<q")
_TIMES = struct.Struct("<qqq")


class Server:
    """A receiver that listens, and passes what arrives to its sink until stop().

    The reader threads call the functions that Sink.open() returned. The other methods of the sink
    are called under one lock, so they must not call the server.

    Args:
        listener: a socket from listen(); stop() closes it.
        access: decides who may connect.
        sink: takes topics, messages and events.
        request: the streams and values that every headset is asked for, until request() changes
            them.
        link: how images give way to the link, until request() changes it; None means that they
            do not.
        is_paused: True starts no stream before begin().
        idle: returns the streams that are not needed at present; called under the lock.
        access_changed: called in a thread of its own when the paired devices have changed.
    """

    def __init__(
        self,
        listener: socket.socket,
        access: Access,
        sink: Sink,
        request: Request,
        settings: ReceiverSettings,
        *,
        link: Link | None = None,
        is_paused: bool = False,
        idle: Callable[[], Collection[str]] = tuple,
        access_changed: Callable[[], None] = lambda: None,
    ) -> None:
        clock, limits = time.monotonic, settings.limits
        context = Context(settings, sink, self._act, clock, idle)
        self._host = Host(context, request, link=link, is_paused=is_paused)
        self._access, self._access_changed = access, access_changed
        self._admission = Admission(limits, clock)
        self._turned_away = EventLimit(sink.event, clock, per_second=1)
        self._failures = EventLimit(self._tell_failure, clock, per_second=1)
        self._sink, self._limits = sink, limits
        self._lock = threading.Lock()
        self._links: dict[Connection, ConnectionIO] = {}
        self._readers: set[threading.Thread] = set()
        self._stopping = threading.Event()
        self._acceptor = Acceptor(
            listener,
            lambda accepted, host, port: self._guarded(self._open, accepted, host, port),
            lambda reason: self._guarded(sink.event, reason),
        )
        ticker = threading.Thread(target=self._tick, name="tick", daemon=True)
        self._threads = [self._acceptor.thread, ticker]
        for thread in self._threads:
            thread.start()

    @property
    def address(self) -> str:
        """The HOST:PORT that the server listens on."""
        return self._acceptor.address

    def listen_on(self, address: tuple[str, int]) -> socket.socket:
        """Listens on another address, as Acceptor.listen_on() does; connections stay open."""
        return self._acceptor.listen_on(address)

    def protection(self) -> Protection:
        """Returns which devices may connect."""
        return self._access.protection()

    def begin(self) -> None:
        """Starts the streams, now or as soon as a headset is ready."""
        with self._lock:
            self._host.begin()

    def pause(self) -> None:
        """Stops all streams until begin(); the headset stays connected."""
        with self._lock:
            self._host.pause()

    def request(self, request: Request, link: Link | None = None) -> None:
        """Requests other streams, values or `link`, as Host.request() does."""
        with self._lock:
            self._host.request(request, link)

    def update(self) -> None:
        """Reads which streams are idle, and requests the change from the headset."""
        with self._lock:
            self._host.update()

    def test_link(self) -> None:
        """Starts a link test of about 2 s; report() has the result.

        Raises:
            LinkTestError: no headset is connected, a test is running, or the app does not answer.
        """
        with self._lock:
            self._host.test_link()

    def report(self) -> Report | None:
        """Returns a snapshot of the current or else the last session; None before the first."""
        with self._lock:
            return self._host.session.report() if self._host.session else None

    def stop(self) -> None:
        """Sends BYE, reads what has arrived and closes all connections, in less than 1 s."""
        self._stopping.set()
        self._acceptor.stop()
        with self._lock:
            self._host.stop()
        self._join(time.monotonic() + _STOP_S)
        for link in list(self._links.values()):
            link.abort()
        self._join(time.monotonic() + _STOP_S)
        self._acceptor.close()

    def _join(self, deadline_s: float) -> None:
        for thread in (*self._threads, *list(self._readers)):
            thread.join(max(0.0, deadline_s - time.monotonic()))

    def _open(self, accepted: socket.socket, host: str, port: int) -> None:
        self._refresh()
        refusal = self._admission.refusal(host)
        if refusal is not None:
            self._turned_away.say(f"{host} is turned away: {refusal}")
            accepted.close()
            return
        try:
            transport = self._access.transport(accepted)
        except OSError:
            accepted.close()  # the peer has disconnected already
            return
        link = ConnectionIO(transport, Connection(host, port, time.monotonic()))
        reader = threading.Thread(target=self._read, args=[link], daemon=True)
        self._links[link.connection] = link
        self._readers.add(reader)
        self._admission.opened(host)
        self._host.opened(link.connection)
        reader.start()

    def _refresh(self) -> None:
        try:
            has_changed = self._access.refresh()
        except KeysError as error:
            self._sink.event(str(error))
            has_changed = True
        if has_changed:
            self._host.expel(self._access.allows)
            threading.Thread(target=self._access_changed, daemon=True).start()

    def _tick(self) -> None:
        while not self._stopping.wait(_TICK_S):
            for task in (self._refresh, self._host.tick, self._abort_overdue):
                self._guarded(task)

    def _abort_overdue(self) -> None:
        now_s = time.monotonic()
        for link in self._links.values():
            if link.abort_s is not None and now_s > link.abort_s:
                link.abort()

    def _guarded[*Ts](self, task: Callable[[*Ts], None], *arguments: *Ts) -> bool:
        """Runs a task under the lock, and returns True if it succeeded.

        An exception that nobody expected, of the sink for example, must not end the thread: the
        receiver would accept no headset any more.
        """
        try:
            with self._lock:
                task(*arguments)
        except Exception as error:
            self._failures.say(f"internal error, please report it: {error!r} in {task.__name__}")
            return False
        return True

    def _tell_failure(self, text: str) -> None:
        try:
            self._sink.event(text)
        except Exception:  # It may be the sink that fails
            print(text, file=sys.stderr, flush=True)

    def _read(self, link: ConnectionIO) -> None:
        fault: str | None = "the receiver failed"
        try:
            if self._handshake(link):
                self._receive(link)
            fault = None if link.parser.is_between_frames else "ended inside a frame"
        except OSError as error:
            fault = error.strerror or str(error)
        finally:
            with self._lock:
                link.transport.close()
                del self._links[link.connection]
                self._readers.discard(threading.current_thread())
                self._admission.closed(link.connection.host)
                self._host.closed(link.connection, fault)

    def _handshake(self, link: ConnectionIO) -> bool:
        """Returns True if the handshake succeeded; closes the connection of unpaired peers."""
        connection = link.connection
        try:
            peer = link.transport.handshake()
        except ProtocolError as error:
            with self._lock:
                self._admission.failed(connection.host)
                self._host.failed(connection, error)
            link.transport.discard()
            return False
        with self._lock:
            connection.peer = peer
            if self._access.allows(peer):
                self._admission.showed(connection.host)
            else:  # unpaired since the handshake began, or signed by a paired device's key
                self._admission.failed(connection.host)
                refusal = ProtocolError(ErrorCode.PAIRING, "it is not paired")
                self._host.failed(connection, refusal)
        return True

    def _receive(self, link: ConnectionIO) -> None:
        try:
            for frame, received_ns in link.frames():
                self._dispatch(link, frame, received_ns)
        except ProtocolError as error:
            with self._lock:
                self._host.failed(link.connection, error)
            link.transport.discard()

    def _dispatch(self, link: ConnectionIO, frame: Frame, received_ns: int) -> None:
        header = frame.header
        if header.kind == Kind.DATA:
            route = link.connection.routes.get(header.channel)
            if route is None:
                with self._lock:
                    raise self._host.refusal(link.connection, header.channel)
            route.receive(frame, received_ns)
        elif header.kind == Kind.TIME_REQUEST:
            (t1,) = _TIME.unpack(frame.body)
            now_ns = time.time_ns()
            times = _TIMES.pack(t1, received_ns, now_ns)
            link.write(encode_frame(Kind.TIME_REPLY, times, send_ns=now_ns))
        else:
            with self._lock:
                self._host.received(link.connection, frame)

    def _act(self, action: Action) -> None:
        link = self._links.get(action.connection)
        if link is None:
            return
        match action:
            case Send(connection, kind, body):
                if kind in (Kind.WELCOME, Kind.JOINED) and connection.lane is not None:
                    link.parser.lane = LaneKind.of(connection.lane)
                body_bytes = body.to_bytes() if body else b""
                link.write(encode_frame(kind, body_bytes, send_ns=time.time_ns()))
            case Close(_, ending):
                link.end(ending, self._limits.linger_s)
