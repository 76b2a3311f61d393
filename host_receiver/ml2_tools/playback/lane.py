"""A connection to a receiver, as the device sees it."""

import socket
import threading
from dataclasses import dataclass

from ml2_receiver.errors import ErrorCode, PlaybackError, ProtocolError
from ml2_receiver.security.contexts import device_context
from ml2_receiver.security.identity import Identity
from ml2_receiver.transport.tls_transport import TlsTransport
from ml2_receiver.transport.transport import PlainTransport, Transport
from ml2_receiver.wire.frame import Frame, FrameParser, Kind, LaneKind, Side, encode_frame
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.messages import Error

_CONNECT_S = 5.0


@dataclass(frozen=True)
class Destination:
    """A receiver: where it is, and the keys it has; without `identity` it is plaintext.

    Receiver and playback are of one user, and show each other the same certificate.
    """

    address: tuple[str, int]
    identity: Identity | None

    @property
    def place(self) -> str:
        return f"{self.address[0]}:{self.address[1]}"


class Lane:
    """One lane, named `name`; any thread may send, one receives.

    Every method raises PlaybackError when the receiver is gone, silent or refuses.
    """

    def __init__(self, destination: Destination, name: str) -> None:
        self.name = name
        try:
            connected = socket.create_connection(destination.address, _CONNECT_S)
        except OSError as error:
            raise PlaybackError(
                f"no receiver at {destination.place}: {error.strerror or error}",
                hint="Start `ml2-receiver run`, or name its address with --receiver.",
            ) from error
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._transport = _secured(connected, destination)
        self._transport.set_timeout(_CONNECT_S)
        self._parser = FrameParser(Side.RECEIVER, LaneKind.of(name))
        self._sending = threading.Lock()

    def set_timeout(self, seconds: float) -> None:
        """How long the receiver may be silent, or take nothing."""
        self._transport.set_timeout(seconds)

    def send(self, kind: Kind, body: JsonBody | bytes = b"", **header: int) -> None:
        data = body if isinstance(body, bytes) else body.to_bytes()
        with self._sending:
            try:
                self._transport.send_all(encode_frame(kind, data, **header))
            except OSError as error:
                raise self._lost(error) from error

    def receive(self) -> Frame | None:
        """The next frame, or None when the receiver has ended the connection."""
        try:
            while count := self._transport.receive(self._parser.get_buffer()):
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
        self._transport.end_output()

    def close(self) -> None:
        self._transport.close()

    def _lost(self, error: OSError) -> PlaybackError:
        return PlaybackError(f"lane {self.name} is lost: {error.strerror or error}")


def _secured(connected: socket.socket, destination: Destination) -> Transport:
    """The connection, once it is sure who is at the other end."""
    identity = destination.identity
    if identity is None:
        return PlainTransport(connected)
    tls = device_context(identity).wrap_socket(connected, do_handshake_on_connect=False)
    try:
        found = TlsTransport(tls)
        fingerprint = found.handshake()
    except ProtocolError as error:
        tls.close()
        raise PlaybackError(
            f"no TLS with the receiver at {destination.place}: {error.message}",
            hint="If the receiver runs with --insecure, this command needs it too.",
        ) from error
    if fingerprint != identity.fingerprint:
        tls.close()
        raise PlaybackError(
            f"the receiver at {destination.place} has other keys: expected fingerprint"
            f" {identity.fingerprint}, found {fingerprint}",
            hint="Use the --keys that the receiver uses.",
        )
    return found
