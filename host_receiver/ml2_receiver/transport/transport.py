"""The transport of one connection: its interface, and the plaintext implementation."""

import fcntl
import socket
import sys
import termios
from contextlib import suppress
from typing import Protocol

_SCRATCH_BYTES = 64 * 1024
# DSCP 48 and 8 in the upper six bits, RFC 2474: what is urgent, as the headset marks the same
# connections, and what gives way to all other data.
CS6, CS1 = 48 << 2, 8 << 2
_INT_BYTES = 4
# The end of tcpi_min_rtt, in microseconds, in struct tcp_info of linux/tcp.h.
_MIN_RTT_END = 152


class Transport(Protocol):
    """The byte stream of one connection.

    Only the reader thread calls handshake(), receive(), receive_available(), discard() and close();
    any thread may call the other methods. All but abort() and close() raise OSError if the
    connection is broken, or if no byte moves for the time of set_timeout().
    """

    def handshake(self) -> str | None:
        """Returns the fingerprint of the peer's certificate, or None if the peer shows none.

        abort() interrupts it.

        Raises:
            ProtocolError: `pairing`; the handshake failed.
        """

    def mark(self, traffic_class: int) -> None:
        """Marks what is sent from now on CS6 or CS1: Wi-Fi sends it before or after other data."""

    def set_timeout(self, seconds: float) -> None:
        """Sets how long receive() and send_all() may wait; call it after handshake().

        Without this call they wait without limit.
        """

    def receive(self, into: memoryview) -> int:
        """Fills `into` and returns the number of bytes, which is less only at the end of input."""

    def receive_available(self, into: memoryview) -> int:
        """Waits for input and returns how much of it `into` has; 0 at the end of input."""

    def send(self, data: bytes) -> bool:
        """Sends without waiting; if it returns False, not all was sent: abort the connection."""

    def send_all(self, data: bytes | memoryview) -> None:
        """Sends all of `data`, and waits for room in the send buffer."""

    def unacknowledged(self) -> int:
        """Returns the bytes that the peer has not acknowledged; 0 when the connection is closed."""

    def least_round_trip_s(self) -> float:
        """Returns the least round trip that TCP has seen; 0 if it does not tell."""

    def end_output(self) -> None:
        """Ends the output; input that arrives from now on may be lost."""

    def end(self) -> None:
        """Ends both directions; receive() still returns input that has arrived."""

    def discard(self) -> None:
        """Discards input until the peer ends its output."""

    def abort(self) -> None:
        """Ends everything at once, and wakes threads that wait."""

    def close(self) -> None:
        """Closes the socket."""


def mark(connected: socket.socket, traffic_class: int) -> None:
    """Marks what the socket sends, as Transport.mark()."""
    with suppress(OSError):  # the peer may have disconnected, which the reader thread will notice
        if connected.family == socket.AF_INET6:
            connected.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_TCLASS, traffic_class)
        connected.setsockopt(socket.IPPROTO_IP, socket.IP_TOS, traffic_class)


def unacknowledged(connected: socket.socket) -> int:
    """Returns what the kernel keeps, as Transport.unacknowledged()."""
    try:
        kept = fcntl.ioctl(connected, termios.TIOCOUTQ, bytes(_INT_BYTES))
    except (OSError, ValueError):  # it is closed
        return 0
    return int.from_bytes(kept, sys.byteorder)


def least_round_trip_s(connected: socket.socket) -> float:
    """Returns what TCP has seen, as Transport.least_round_trip_s()."""
    try:
        info = connected.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _MIN_RTT_END)
    except OSError:  # it is closed
        return 0.0
    if len(info) < _MIN_RTT_END:
        return 0.0
    return int.from_bytes(info[-_INT_BYTES:], sys.byteorder) * 1e-6


class PlainTransport:
    """A Transport without TLS."""

    def __init__(self, connected: socket.socket) -> None:
        self._socket = connected

    def handshake(self) -> None:
        """Does nothing: any peer is accepted."""

    def mark(self, traffic_class: int) -> None:
        mark(self._socket, traffic_class)

    def set_timeout(self, seconds: float) -> None:
        self._socket.settimeout(seconds)

    def receive(self, into: memoryview) -> int:
        return self._socket.recv_into(into, 0, socket.MSG_WAITALL)

    def receive_available(self, into: memoryview) -> int:
        return self._socket.recv_into(into)

    def send(self, data: bytes) -> bool:
        try:
            return self._socket.send(data, socket.MSG_DONTWAIT) == len(data)
        except BlockingIOError:
            return False

    def send_all(self, data: bytes | memoryview) -> None:
        self._socket.sendall(data)

    def unacknowledged(self) -> int:
        return unacknowledged(self._socket)

    def least_round_trip_s(self) -> float:
        return least_round_trip_s(self._socket)

    def end_output(self) -> None:
        self._socket.shutdown(socket.SHUT_WR)

    def end(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)

    def discard(self) -> None:
        scratch = bytearray(_SCRATCH_BYTES)
        while self._socket.recv_into(scratch):
            pass

    def abort(self) -> None:
        with suppress(OSError):  # the peer may have disconnected
            self._socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        self._socket.close()
