"""The transport of a Connection."""

import struct
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from ipaddress import ip_address
from math import inf

from ..transport.transport import CS1, CS6, Transport
from ..wire.frame import Frame, FrameParser, encode_frame
from ..wire.json_body import JsonBody
from ..wire.kinds import BULK_LANES, ROS, ROS_LANES, Kind, Side
from .actions import Ending
from .connection import Connection
from .openings import Openings
from .subscription_queue import Pieces

_SMALL_FRAMES_BYTES = 64 * 1024
# The last frames of a lane wait for this long while a message is being written.
_MESSAGE_S = 0.05
_TIME = struct.Struct("<q")
_TIMES = struct.Struct("<qqq")


@dataclass(eq=False)
class ConnectionIO:
    """The transport and the parser of a Connection.

    Only the reader thread of the connection receives, parses and closes. After `abort_s`, monotonic
    time, the connection is to be aborted.
    """

    transport: Transport
    connection: Connection
    parser: FrameParser = field(default_factory=lambda: FrameParser(Side.DEVICE))
    abort_s: float = inf
    is_aborted: bool = False
    _writing: threading.Lock = field(default_factory=threading.Lock)
    _writer: threading.Thread | None = None

    def frames(self) -> Iterator[tuple[Frame, int]]:
        """Yields each frame with the ROS time in ns at which its last byte was received.

        It ends with the input or with abort().

        Raises:
            OSError: the connection is broken.
            ProtocolError: as FrameParser.
        """
        parser, receive = self.parser, self.transport.receive
        while not self.is_aborted:
            if 0 < parser.lane.max_payload_bytes <= _SMALL_FRAMES_BYTES:
                yield from self._small_frames()
                return
            count = receive(parser.get_buffer())
            received_ns = time.time_ns()
            if not count:
                return
            if (frame := parser.buffer_updated(count)) is not None:
                yield frame, received_ns

    def _small_frames(self) -> Iterator[tuple[Frame, int]]:
        # Each call of the transport waits for the interpreter, beside all the threads of images
        received = memoryview(bytearray(_SMALL_FRAMES_BYTES))
        while not self.is_aborted and (count := self.transport.receive_available(received)):
            received_ns = time.time_ns()
            for frame in self.parser.feed(received[:count]):
                yield frame, received_ns

    def send(self, kind: Kind, body: JsonBody | None) -> None:
        """Sends a frame of the session; WELCOME and JOINED open the connection's lane.

        It never waits: a connection whose peer has left the send buffer full is aborted.
        """
        if kind in (Kind.WELCOME, Kind.JOINED) and self.connection.lane is not None:
            has_openings = self.connection.openings is not None
            self.parser.enter(self.connection.lane, has_openings=has_openings)
            if self.connection.lane.is_urgent:
                self.transport.mark(CS6)
            elif self.connection.lane in BULK_LANES:
                self.transport.mark(CS1)
        body_bytes = body.to_bytes() if body else b""
        self._write(encode_frame(kind, body_bytes, send_ns=time.time_ns()))
        openings = self.connection.openings
        lane = self.connection.lane
        if lane in ROS_LANES and openings is not None:
            assert lane is not None
            send_all = self._send_all
            if lane is not ROS and not ip_address(self.connection.host).is_loopback:
                send_all = self._send_paced
            self._writer = threading.Thread(
                target=openings.downlink.write,
                args=[lane, send_all],
                name=f"{lane.name}-writer",
                daemon=True,
            )
            self._writer.start()

    def _send_all(self, pieces: Pieces) -> None:
        with self._writing:
            for piece in pieces:
                self.transport.send_all(piece)

    def _send_paced(self, pieces: Pieces) -> None:
        assert self.connection.openings is not None
        pacing = self.connection.openings.downlink.pacing
        with self._writing:
            for piece in pieces:
                pacing.send(piece, self.transport)

    def answer_time(self, request: Frame, received_ns: int) -> None:
        """Sends the TIME_REPLY to a TIME_REQUEST that was received at this ROS time.

        Waits for room in the send buffer: only the reader of the time lane calls it.
        """
        (asked_ns,) = _TIME.unpack(request.body)
        now_ns = time.time_ns()
        times = _TIMES.pack(asked_ns, received_ns, now_ns)
        with suppress(OSError):  # the peer has disconnected, which the reader thread will notice
            self.transport.send_all(encode_frame(Kind.TIME_REPLY, times, send_ns=now_ns))
        if (openings := self.connection.openings) is not None:
            openings.downlink.pacing.requested((received_ns - asked_ns) * 1e-9)

    def pass_on(self, frame: Frame, openings: Openings) -> None:
        """Passes on a frame of an opening; sends FAILURE if it is a request too many.

        That waits for the writer and for room: a peer that does not read can ask no more.
        """
        lane, header = self.connection.lane, frame.header
        failure = openings.received(lane.name if lane else "", frame)
        if failure is not None:
            fields = {"channel": header.channel, "sequence": header.sequence}
            body = failure.to_bytes()
            sent = encode_frame(Kind.FAILURE, body, **fields, send_ns=time.time_ns())
            with suppress(OSError):  # the peer has disconnected, which the reader will notice
                self._send_all([sent])

    def _write(self, data: bytes) -> None:
        """Sends without waiting, for the session waits too; aborts the connection if it is full.

        A message that is being written ends first, if it does so soon.
        """
        is_sent = False
        if self._writing.acquire(timeout=_MESSAGE_S):
            try:
                is_sent = self.transport.send(data)
            except OSError:
                return  # the peer has disconnected, which the reader thread will notice
            finally:
                self._writing.release()
        if not is_sent:
            self.abort()

    def end(self, ending: Ending, linger_s: float) -> None:
        """Starts to close the connection as `ending` says; it is aborted after `linger_s`."""
        if ending is Ending.ABORT:
            self.abort()
            return
        self.abort_s = time.monotonic() + linger_s
        with suppress(OSError):  # the peer may have disconnected
            if ending is Ending.DISCARD:
                self.transport.end_output()
            else:
                self.transport.end()

    def abort(self) -> None:
        self.is_aborted = True
        self.transport.abort()

    def end_writer(self) -> None:
        """Ends the writer of messages, if there is one, and with it the connection."""
        if self._writer is not None and self.connection.openings is not None:
            self.abort()
            self.connection.openings.downlink.stop()
            self._writer.join()
