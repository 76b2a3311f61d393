"""The bytes of one connection, in the clear; tls_transport has them in TLS."""

import socket
from contextlib import suppress
from typing import Protocol

_SCRATCH_BYTES = 64 * 1024


class Transport(Protocol):
    """One thread, the reader, calls handshake(), receive(), discard() and close().

    Any thread may call the others. All but abort() and close() raise OSError when the connection
    is broken, or nothing moves for the time that set_timeout() has set.
    """

    def handshake(self) -> str | None:
        """The fingerprint of who is there, None where nobody shows one; abort() ends it.

        Raises:
            ProtocolError: `pairing`.
        """

    def set_timeout(self, seconds: float) -> None:
        """How long receive() and send_all() may wait; for ever unless called after handshake()."""

    def receive(self, into: memoryview) -> int:
        """Fills `into`; less only at the end of what the peer sends."""

    def send(self, data: bytes) -> bool:
        """Never waits; if not all was taken at once, False, and the connection is of no use."""

    def send_all(self, data: bytes) -> None:
        """Waits until all is taken."""

    def end_output(self) -> None:
        """Nothing more will be sent; what arrives from now on may be lost."""

    def end(self) -> None:
        """Ends both directions; what has arrived is still received."""

    def discard(self) -> None:
        """Waits for the end of what the peer sends."""

    def abort(self) -> None:
        """Ends everything at once, what another thread waits for included."""

    def close(self) -> None:
        """Frees it."""


class PlainTransport:
    """A Transport without TLS."""

    def __init__(self, connected: socket.socket) -> None:
        self._socket = connected

    def handshake(self) -> None:
        """Whoever comes is let in."""

    def set_timeout(self, seconds: float) -> None:
        self._socket.settimeout(seconds)

    def receive(self, into: memoryview) -> int:
        return self._socket.recv_into(into, 0, socket.MSG_WAITALL)

    def send(self, data: bytes) -> bool:
        try:
            return self._socket.send(data, socket.MSG_DONTWAIT) == len(data)
        except BlockingIOError:
            return False

    def send_all(self, data: bytes) -> None:
        self._socket.sendall(data)

    def end_output(self) -> None:
        self._socket.shutdown(socket.SHUT_WR)

    def end(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)

    def discard(self) -> None:
        scratch = bytearray(_SCRATCH_BYTES)
        while self._socket.recv_into(scratch):
            pass

    def abort(self) -> None:
        with suppress(OSError):  # the peer may have gone
            self._socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        self._socket.close()
