"""The device side of a connection to a receiver."""

import socket
import threading
from dataclasses import dataclass

from ml2_receiver.errors import ErrorCode, ProtocolError
from ml2_receiver.security.contexts import device_context
from ml2_receiver.security.identity import Identity
from ml2_receiver.table.reader import load_table
from ml2_receiver.transport.tls_transport import TlsTransport
from ml2_receiver.transport.transport import PlainTransport, Transport
from ml2_receiver.wire.frame import Frame, FrameParser, encode_frame
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.kinds import Kind, Side
from ml2_receiver.wire.messages import Error

from ..errors import PlaybackError

_CONNECT_S = 5.0


@dataclass(frozen=True)
class Destination:
    """A receiver's address and its keys; without `identity` the connection is plaintext.

    Receiver and playback belong to the same user and present the same certificate.
    """

    address: tuple[str, int]
    identity: Identity | None

    @property
    def host_port(self) -> str:
        return f"{self.address[0]}:{self.address[1]}"


class Lane:
    """One lane of a session. Any thread may send; only one thread may receive.

    Every method raises PlaybackError if the connection is lost, times out or is refused.
    """

    def __init__(self, destination: Destination, name: str) -> None:
        self.name = name
        try:
            connected = socket.create_connection(destination.address, _CONNECT_S)
        except OSError as error:
            raise PlaybackError(
                f"no receiver at {destination.host_port}: {error.strerror or error}",
                hint="Start `ml2-receiver run`, or name its address with --receiver.",
            ) from error
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._transport = _secure(connected, destination)
        self._transport.set_timeout(_CONNECT_S)
        self._parser = FrameParser(Side.RECEIVER, load_table().lane(name))
        self._sending = threading.Lock()

    def set_timeout(self, seconds: float) -> None:
        """Sets how long one receive or one send may block."""
        self._transport.set_timeout(seconds)

    def send(self, kind: Kind, body: JsonBody | bytes = b"", **header: int) -> None:
        data = body if isinstance(body, bytes) else body.to_bytes()
        with self._sending:
            try:
                self._transport.send_all(encode_frame(kind, data, **header))
            except OSError as error:
                raise self._lost_error(error) from error

    def receive(self) -> Frame | None:
        """Returns the next frame, or None after the receiver has closed the connection."""
        try:
            while count := self._transport.receive(self._parser.get_buffer()):
                frame = self._parser.buffer_updated(count)
                if frame is not None:
                    return frame
        except OSError as error:
            raise self._lost_error(error) from error
        except ProtocolError as error:
            raise PlaybackError(f"the receiver violated the protocol: {error}") from error
        return None

    def expect(self, kind: Kind) -> bytearray:
        """Returns the body of the next frame, which must be of this kind.

        Raises:
            PlaybackError: the receiver sends ERROR or closes the connection.
            ProtocolError: the frame is of another kind.
        """
        frame = self.receive()
        if frame is None:
            raise PlaybackError(f"expected {kind.name}, but the receiver ended lane {self.name}")
        if frame.header.kind == Kind.ERROR:
            error = Error.parse(frame.body)
            raise PlaybackError(f"the receiver refuses: {error.code}: {error.message}")
        if frame.header.kind != kind:
            raise ProtocolError(ErrorCode.UNEXPECTED, f"expected {kind.name}, found {frame.header}")
        return frame.body

    def end_output(self) -> None:
        """Closes the sending direction of the connection."""
        self._transport.end_output()

    def close(self) -> None:
        self._transport.close()

    def _lost_error(self, error: OSError) -> PlaybackError:
        return PlaybackError(f"lane {self.name} is lost: {error.strerror or error}")


def _secure(connected: socket.socket, destination: Destination) -> Transport:
    """Returns the connection after the TLS handshake and the check of the certificate."""
    identity = destination.identity
    if identity is None:
        return PlainTransport(connected)
    tls = device_context(identity).wrap_socket(connected, do_handshake_on_connect=False)
    try:
        transport = TlsTransport(tls)
        fingerprint = transport.handshake()
    except ProtocolError as error:
        tls.close()
        raise PlaybackError(
            f"no TLS with the receiver at {destination.host_port}: {error.message}",
            hint="If the receiver runs with --insecure, run this command with --insecure, too.",
        ) from error
    if fingerprint != identity.fingerprint:
        tls.close()
        raise PlaybackError(
            f"the receiver at {destination.host_port} has other keys: expected fingerprint"
            f" {identity.fingerprint}, found {fingerprint}",
            hint="Use the --keys that the receiver uses.",
        )
    return transport
