"""The threads of a receiver: a reader per connection, an acceptor and a timer."""

import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

from ..errors import ErrorCode, KeysError, ProtocolError, PublishError
from ..transport.access import Access
from ..wire.frame import Frame
from ..wire.kinds import Kind
from ..wire.messages import Link
from .acceptor import Acceptor
from .actions import Action, Close, EndWill, Log, Open, Send, SessionEnded
from .address_limits import AddressLimits
from .connection import Connection
from .connection_io import ConnectionIO
from .demand import Demand
from .event_limit import Cause, event_limits
from .host import Host
from .openings import LANE_KINDS
from .report import Report
from .settings import ReceiverSettings
from .sink import Applied, Sink
from .steps import Steps
from .streams import DesiredStreams, Request

_TICK_S = 0.1
_STOP_S = 0.3


class Server:
    """A receiver that passes what arrives to its sink, from start() until stop().

    All threads act in Steps, so the sink is not called under the lock of the Host. Of the server it
    may call report(), paired() and demand() alone. The reader threads call the functions that
    Sink.open() returned.

    Args:
        listener: a socket from listen(); stop() closes it.
        access: decides who may connect.
        sink: takes topics, messages and events.
        request: the streams and values that every headset is asked for, until request() changes
            them.
        link: how images give way to the link, until request() changes it; None means that they
            do not.
        is_lazy: True lets streams rest that no output needs, until request() changes it.
        is_paused: True starts no stream before begin().
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
        is_lazy: bool = False,
        is_paused: bool = False,
        access_changed: Callable[[], None] = lambda: None,
    ) -> None:
        self._host = Host(settings)
        self._desired = DesiredStreams(request, is_paused, (), settings.excluded, link)
        self._access, self._access_changed = access, access_changed
        self._address_limits = AddressLimits(settings.limits, time.monotonic)
        self._sink, self._demand, self._is_lazy = sink, Demand(), is_lazy
        self._log_limits = event_limits(sink.event, time.monotonic)
        self._linger_s = settings.limits.linger_s
        self._steps = Steps(self._host, self._act)
        self._connections: dict[Connection, ConnectionIO] = {}
        self._readers: list[threading.Thread] = []
        self._wake = threading.Event()  # the ticker
        self._is_stopping = False
        self._acceptor = Acceptor(
            listener,
            lambda *accepted: bool(self._steps.guarded(lambda: self._open(*accepted))),
            lambda reason: self._steps.guarded(lambda: self._log(reason, "receiver")),
        )
        ticker = threading.Thread(target=self._tick, name="tick", daemon=True)
        self._threads = [self._acceptor.thread, ticker]

    def start(self) -> None:
        """Accepts connections from now on; those that came since listen() have waited."""
        for thread in self._threads:
            thread.start()

    @property
    def address(self) -> str:
        """The HOST:PORT that the server listens on."""
        return self._acceptor.address

    def listen_on(self, address: tuple[str, int]) -> socket.socket:
        """Listens on another address, as Acceptor.listen_on() does; connections stay open."""
        return self._acceptor.listen_on(address)

    def paired(self) -> Mapping[str, str] | None:
        """Returns which devices may connect, as Access.paired()."""
        return self._access.paired()

    def begin(self) -> None:
        """Starts the streams, now or as soon as a headset is ready."""
        with self._update():
            self._desired = replace(self._desired, is_paused=False)

    def pause(self) -> None:
        """Stops all streams until begin(); the headset stays connected."""
        with self._update():
            self._desired = replace(self._desired, is_paused=True)

    def request(self, request: Request, link: Link | None = None, *, is_lazy: bool = False) -> None:
        """Requests other streams, values or `link`; streams with unchanged values continue."""
        with self._update():
            self._is_lazy = is_lazy
            self._desired = replace(self._desired, request=request, link=link)

    def demand(self, output: str, streams: Mapping[str, bool]) -> None:
        """Takes the streams that an output publishes now, each with whether it is needed.

        Returns at once.
        """
        self._demand.push(output, streams)
        self._wake.set()

    def test_link(self) -> None:
        """Starts a link test of about 2 s; report() has the result.

        Raises:
            LinkTestError: no headset is connected, a test is running, or the app does not answer.
        """
        with self._steps.step() as now_s:
            self._host.test_link(now_s)

    def report(self) -> Report | None:
        """Returns a snapshot of the current or else the last session; None before the first."""
        with self._steps.host_lock:
            return self._host.session.report(time.monotonic()) if self._host.session else None

    def stop(self) -> None:
        """Sends BYE, reads what has arrived and closes all connections, in less than 1 s."""
        self._is_stopping = True
        self._wake.set()
        self._acceptor.stop()
        with self._steps.step():
            self._host.stop()
        self._join(time.monotonic() + _STOP_S)
        for io in list(self._connections.values()):
            io.abort()
        self._join(time.monotonic() + _STOP_S)
        self._acceptor.close()

    def _join(self, deadline_s: float) -> None:
        for thread in (*self._threads, *self._readers):
            thread.join(max(0.0, deadline_s - time.monotonic()))

    def _open(self, accepted: socket.socket, host: str, port: int) -> bool:
        self._refresh()
        refusal = self._address_limits.refusal(host)
        if refusal is not None:
            self._log(f"{host} is turned away: {refusal}", "turned away")
            return False
        try:
            transport = self._access.transport(accepted)
        except OSError:  # the peer has disconnected already
            return False
        io = ConnectionIO(transport, Connection(host, port, time.monotonic()))
        reader = threading.Thread(target=self._read, args=[io], daemon=True)
        self._connections[io.connection] = io
        self._address_limits.opened(host)
        self._host.opened(io.connection)
        reader.start()
        self._readers = [it for it in self._readers if it.is_alive()] + [reader]
        return True

    def _refresh(self) -> None:
        try:
            has_changed = self._access.refresh()
        except KeysError as error:
            self._log(str(error), "receiver")
            has_changed = True
        if has_changed:
            self._host.expel(self._access.allows, time.monotonic())
            threading.Thread(target=self._access_changed, daemon=True).start()

    def _tick(self) -> None:
        while not self._is_stopping:
            self._steps.guarded(self._refresh)
            self._steps.guarded(lambda: self._host.tick(time.monotonic()))
            self._steps.guarded(lambda: self._request(time.monotonic()))
            with self._steps.output_lock:
                for io in list(self._connections.values()):
                    if time.monotonic() > io.abort_s:
                        io.abort()
            self._wake.wait(_TICK_S)
            self._wake.clear()

    @contextmanager
    def _update(self) -> Iterator[float]:
        """A step that ends by requesting the streams that are desired and not idle."""
        with self._steps.step() as now_s:
            yield now_s
            self._request(now_s)

    def _request(self, now_s: float) -> None:
        idle = self._demand.idle_streams(now_s) if self._is_lazy else ()
        self._host.update(replace(self._desired, idle=idle), now_s)

    def _read(self, io: ConnectionIO) -> None:
        fault: str | None = "the receiver failed"
        try:
            if self._handshake(io):
                self._receive(io)
            fault = None if io.parser.is_between_frames else "ended inside a frame"
        except OSError as error:
            fault = error.strerror or str(error)
        finally:
            # Else the next socket of this number could be written to
            with self._steps.output_lock:
                del self._connections[io.connection]
            io.end_writer()
            io.transport.close()
            io.connection.end_wills()
            with self._steps.step() as now_s:
                self._address_limits.closed(io.connection.host)
                self._host.closed(io.connection, fault, now_s)

    def _handshake(self, io: ConnectionIO) -> bool:
        """Returns True if the handshake succeeded; closes the connection of unpaired peers."""
        connection = io.connection
        try:
            peer = io.transport.handshake()
            with self._steps.step():
                connection.peer = peer
                # It may be unpaired since the handshake began, or signed by a paired device's key
                if not self._access.allows(peer):
                    raise ProtocolError(ErrorCode.PAIRING, "it is not paired")
                self._address_limits.showed(connection.host)
                return True
        except ProtocolError as error:
            with self._steps.step():
                self._address_limits.failed(connection.host)
                self._host.failed(connection, error)
            io.transport.discard()
            return False

    def _receive(self, io: ConnectionIO) -> None:
        try:
            for frame, received_ns in io.frames():
                self._dispatch(io, frame, received_ns)
        except ProtocolError as error:
            with self._steps.step():
                self._host.failed(io.connection, error)
            io.transport.discard()

    def _dispatch(self, io: ConnectionIO, frame: Frame, received_ns: int) -> None:
        header = frame.header
        if header.kind == Kind.DATA:
            route = io.connection.routes.get(header.channel)
            if route is None:
                with self._steps.host_lock:
                    raise self._host.refusal(io.connection, header.channel)
            route.receive(frame, received_ns, time.time_ns())
        elif header.kind == Kind.TIME_REQUEST:
            io.answer_time(frame, received_ns)
        elif header.kind in LANE_KINDS and io.connection.openings is not None:
            io.pass_on(frame, io.connection.openings)
        else:
            with self._update() as now_s:
                self._host.received(io.connection, frame, now_s)

    def _act(self, action: Action) -> None:
        match action:
            case Send(connection, kind, body) if io := self._connections.get(connection):
                io.send(kind, body)
            case Close(connection, ending) if io := self._connections.get(connection):
                io.end(ending, self._linger_s)
            case Open():
                self._open_topic(action)
            case EndWill(will):
                will.close()
            case Applied():
                self._sink.configured(action)
            case SessionEnded(report):
                self._sink.session_ended(report)
            case Log(text, cause):
                self._log_limits[cause].say(text)

    def _open_topic(self, action: Open) -> None:
        try:
            action.route.publish = self._sink.open(action.topic)
        except PublishError as refusal:
            with self._steps.host_lock:
                self._host.topic_refused(action, str(refusal), time.monotonic())

    def _log(self, text: str, cause: Cause) -> None:
        self._host.actions.append(Log(text, cause))
