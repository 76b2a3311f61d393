"""Sockets and threads around the Host: one reader per connection, one that accepts, one clock."""

import errno
import socket
import struct
import threading
import time
from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import dataclass, field

from ..configuration.table import StreamTable
from ..doctor.process_table import listener_of
from ..errors import ListenError, ProtocolError
from ..topics.sink import Sink
from ..wire.frame import Frame, FrameParser, Kind, LaneKind, Side, encode_frame
from ..wire.json_body import JsonBody
from .connection import Connection
from .context import Action, Close, Context, Ending, Limits, Send
from .host import Host
from .report import Report
from .streams import Request

_LIMITS = Limits()
_TICK_S = 0.1
_STOP_S = 0.3
_BACKLOG = 64
# Takes every control frame whole, so that one send() tells whether the peer reads at all.
_SEND_BUFFER_BYTES = 128 * 1024
_SCRATCH_BYTES = 64 * 1024
_TIME = struct.Struct("<q")
_TIMES = struct.Struct("<qqq")


@dataclass(eq=False)
class _Link:
    """The socket side of a Connection. Its reader alone receives, parses and closes."""

    socket: socket.socket
    connection: Connection
    parser: FrameParser = field(default_factory=lambda: FrameParser(Side.DEVICE))
    abort_s: float | None = None
    is_aborted: bool = False

    def abort(self) -> None:
        self.is_aborted = True
        with suppress(OSError):  # the peer may have gone
            self.socket.shutdown(socket.SHUT_RDWR)


class Server:
    """Listens, receives and feeds the sink until stop().

    The sink's publishing functions are called by the lanes' readers, everything else of it under
    one lock, so the sink must not call back from there.

    Args:
        listener: what listen() returned; closed by stop().
        request: the streams and values every headset is asked for, until request() changes them.
        name: what headsets are told about who receives.
        frame_prefix: what their frame ids are to begin with.
        is_paused: START waits for begin().
        idle: the streams that nobody needs at present; called under the lock.
    """

    def __init__(
        self,
        listener: socket.socket,
        table: StreamTable,
        request: Request,
        sink: Sink,
        *,
        name: str,
        software: str,
        frame_prefix: str = "",
        is_paused: bool = False,
        idle: Callable[[], Collection[str]] = tuple,
        limits: Limits = _LIMITS,
    ) -> None:
        context = Context(
            table, sink, limits, self._act, time.monotonic, name, software, idle, frame_prefix
        )
        self._host = Host(context, request, is_paused=is_paused)
        self._sink, self._limits = sink, limits
        self._lock = threading.Lock()
        self._links: dict[Connection, _Link] = {}
        self._readers: set[threading.Thread] = set()
        self._stopping = threading.Event()
        self._listener = listener
        self._threads = [
            threading.Thread(target=self._accept, name="accept", daemon=True),
            threading.Thread(target=self._tick, name="tick", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    @property
    def address(self) -> str:
        """HOST:PORT as it is listened on."""
        return _text(self._listener.getsockname())

    def begin(self) -> None:
        """Lets the streams run, now or as soon as a headset is ready for it."""
        with self._lock:
            self._host.start()

    def pause(self) -> None:
        """Stops all streams until begin(); the headset stays connected."""
        with self._lock:
            self._host.pause()

    def request(self, request: Request) -> None:
        """Asks for other streams or values; streams whose values stay go on undisturbed."""
        with self._lock:
            self._host.request(request)

    def update(self) -> None:
        """Which streams are idle has changed."""
        with self._lock:
            self._host.update()

    def report(self) -> Report | None:
        """The session there is, or the last one."""
        with self._lock:
            return self._host.session.report() if self._host.session else None

    def stop(self) -> None:
        """Says goodbye, reads what has arrived, and returns in less than a second."""
        self._stopping.set()
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        with self._lock:
            self._host.stop()
        self._join(time.monotonic() + _STOP_S)
        for link in list(self._links.values()):
            link.abort()
        self._join(time.monotonic() + _STOP_S)
        self._listener.close()

    def _join(self, deadline_s: float) -> None:
        for thread in (*self._threads, *list(self._readers)):
            thread.join(max(0.0, deadline_s - time.monotonic()))

    def _accept(self) -> None:
        while not self._stopping.is_set():
            try:
                accepted, address = self._listener.accept()
            except OSError as error:
                if not self._stopping.wait(_TICK_S):
                    with self._lock:
                        self._sink.event(f"cannot accept connections: {error}")
                continue
            link = _Link(accepted, Connection(_text(address), time.monotonic()))
            reader = threading.Thread(target=self._read, args=[link], daemon=True)
            with self._lock:
                self._links[link.connection] = link
                self._readers.add(reader)
                self._host.opened(link.connection)
            reader.start()

    def _tick(self) -> None:
        while not self._stopping.wait(_TICK_S):
            with self._lock:
                self._host.tick()
                now_s = time.monotonic()
                for link in self._links.values():
                    if link.abort_s is not None and now_s > link.abort_s:
                        link.abort()

    def _read(self, link: _Link) -> None:
        fault: str | None = "the receiver failed"
        try:
            self._receive(link)
            fault = None if link.parser.is_between_frames else "ended inside a frame"
        except OSError as error:
            fault = error.strerror
        finally:
            with self._lock:
                link.socket.close()
                del self._links[link.connection]
                self._readers.discard(threading.current_thread())
                self._host.closed(link.connection, fault)

    def _receive(self, link: _Link) -> None:
        receive, parser = link.socket.recv_into, link.parser
        while not link.is_aborted:
            count = receive(parser.get_buffer(), 0, socket.MSG_WAITALL)
            received_ns = time.time_ns()
            if not count:
                return
            try:
                frame = parser.buffer_updated(count)
                if frame is not None:
                    self._dispatch(link, frame, received_ns)
            except ProtocolError as error:
                with self._lock:
                    self._host.failed(link.connection, error)
                _discard(link)
                return

    def _dispatch(self, link: _Link, frame: Frame, received_ns: int) -> None:
        header = frame.header
        if header.kind == Kind.DATA:
            route = link.connection.routes.get(header.channel)
            if route is None:
                with self._lock:
                    raise self._host.refusal(link.connection, header.channel)
            route.receive(frame, received_ns)
        elif header.kind == Kind.TIME_REQUEST:
            (t1,) = _TIME.unpack(frame.payload)
            now_ns = time.time_ns()
            times = _TIMES.pack(t1, received_ns, now_ns)
            _write(link, encode_frame(Kind.TIME_REPLY, times, send_ns=now_ns))
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
                _write(link, _encode(kind, body))
            case Close(_, Ending.ABORT):
                link.abort()
            case Close(_, ending):
                link.abort_s = time.monotonic() + self._limits.linger_s
                with suppress(OSError):  # the peer may have gone
                    link.socket.shutdown(
                        socket.SHUT_WR if ending is Ending.DISCARD else socket.SHUT_RDWR
                    )


def _encode(kind: Kind, body: JsonBody | None) -> bytes:
    return encode_frame(kind, body.to_bytes() if body else b"", send_ns=time.time_ns())


def _write(link: _Link, data: bytes) -> None:
    """Never waits for a peer: one that leaves a whole send buffer unread is cut off."""
    try:
        count = link.socket.send(data, socket.MSG_DONTWAIT)
    except BlockingIOError:
        count = 0
    except OSError:
        return  # it has gone, as its reader will find
    if count < len(data):
        link.abort()


def _discard(link: _Link) -> None:
    scratch = bytearray(_SCRATCH_BYTES)
    while not link.is_aborted and link.socket.recv_into(scratch):
        pass


def listen(address: tuple[str, int]) -> socket.socket:
    """A socket for Server; port 0 lets the system choose.

    Raises:
        ListenError: the address cannot be listened on.
    """
    try:
        family, *_, resolved = socket.getaddrinfo(*address, type=socket.SOCK_STREAM)[0]
        listener = socket.create_server(
            resolved[:2], family=family, backlog=_BACKLOG, dualstack_ipv6=False
        )
    except OSError as error:
        reason = f"cannot listen on {_text(address)}: {error.strerror}"
        if error.errno == errno.EADDRINUSE:
            holder = listener_of(address[1])
            reason += f", by {holder or 'a process of another user'}; end it, or --listen elsewhere"
        raise ListenError(reason) from error
    # Linux gives these to every connection it accepts.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER_BYTES)
    return listener


def _text(address: tuple[str, int]) -> str:
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
