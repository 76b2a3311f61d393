"""A connection to a receiver, as the device sees it."""

import socket
import threading

from ..errors import ErrorCode, PlaybackError, ProtocolError
from ..wire.frame import Frame, FrameParser, Kind, LaneKind, Side, encode_frame
from ..wire.json_body import JsonBody
from ..wire.messages import Error

_CONNECT_S = 5.0


class Lane:
    """One lane, named `name`; any thread may send, one receives.

    Every method raises PlaybackError when the receiver is gone, silent or refuses.
    """

    def __init__(self, address: tuple[str, int], name: str) -> None:
        self.name = name
        try:
            self._socket = socket.create_connection(address, _CONNECT_S)
        except OSError as error:
            place = f"{address[0]}:{address[1]}"
            raise PlaybackError(
                f"no receiver at {place}: {error.strerror or error}; start `ml2-receiver run`"
            ) from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._parser = FrameParser(Side.RECEIVER, LaneKind.of(name))
        self._sending = threading.Lock()

    def set_timeout(self, seconds: float) -> None:
        """How long the receiver may be silent, or take nothing."""
        self._socket.settimeout(seconds)

    def send(self, kind: Kind, body: JsonBody | bytes = b"", **header: int) -> None:
        data = body if isinstance(body, bytes) else body.to_bytes()
        with self._sending:
            try:
                self._socket.sendall(encode_frame(kind, data, **header))
            except OSError as error:
                raise self._lost(error) from error

    def receive(self) -> Frame | None:
        """The next frame, or None when the receiver has ended the connection."""
        try:
            while count := self._socket.recv_into(self._parser.get_buffer()):
                frame = self._parser.buffer_updated(count)
                if frame is not None:
                    return frame
        except OSError as error:
            raise self._lost(error) from error
        except ProtocolError as error:
            raise PlaybackError(f"the receiver broke the protocol: {error}") from error
        return None

    def expect(self, kind: Kind) -> bytearray:
        """The body of the next frame, which has to be of this kind."""
        frame = self.receive()
        if frame is None:
            raise PlaybackError(f"expected {kind.name}, but the receiver ended lane {self.name}")
        if frame.header.kind == Kind.ERROR:
            error = Error.parse(frame.payload)
            raise PlaybackError(f"the receiver refuses: {error.code}: {error.message}")
        if frame.header.kind != kind:
            raise ProtocolError(ErrorCode.UNEXPECTED, f"expected {kind.name}, found {frame.header}")
        return frame.payload

    def end_output(self) -> None:
        """Nothing more will be sent."""
        self._socket.shutdown(socket.SHUT_WR)

    def close(self) -> None:
        self._socket.close()

    def _lost(self, error: OSError) -> PlaybackError:
        return PlaybackError(f"lane {self.name} is lost: {error.strerror or error}")
