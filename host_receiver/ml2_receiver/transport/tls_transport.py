"""The transport of one connection over TLS."""

import select
import socket
import ssl
import threading
from contextlib import suppress

from ..errors import ErrorCode, ProtocolError
from ..security.contexts import ALPN
from ..security.identity import fingerprint
from ..wire.frame import MAGIC
from .transport import least_round_trip_s, mark, unacknowledged

_MAGIC_BYTE = bytes([MAGIC & 0xFF])
_SCRATCH_BYTES = 64 * 1024
# These bypass TLS. SSLSocket's own methods would end TLS and go on in plaintext, or raise.
_peek, _send_raw, _receive_raw = socket.socket.recv, socket.socket.send, socket.socket.recv_into
_shutdown = socket.socket.shutdown
_REFUSALS = {
    "CERTIFICATE_VERIFY_FAILED": "it is not paired: run `ml2-receiver pair`",
    "PEER_DID_NOT_RETURN_A_CERTIFICATE": "it shows no certificate: run `ml2-receiver pair`",
    "UNSUPPORTED_PROTOCOL": "it does not speak TLS 1.3",
    "WRONG_VERSION_NUMBER": "it does not speak TLS",
}
_PLAINTEXT = "this port speaks TLS only: run `ml2-receiver pair`, or start both with --insecure"


class TlsTransport:
    """A Transport over an SSLSocket that has not done its handshake.

    OpenSSL must not read and write one connection at the same time. So the socket is non-blocking,
    and a lock is held during OpenSSL's calls but not while waiting.
    """

    def __init__(self, tls: ssl.SSLSocket) -> None:
        self._tls = tls
        self._lock = threading.Lock()
        self._is_open = self._is_plain = self._has_ended = False
        self._timeout_ms: float | None = None
        self._readable, self._writable = select.poll(), select.poll()
        self._readable.register(tls, select.POLLIN)
        self._writable.register(tls, select.POLLOUT)

    def handshake(self) -> str | None:
        try:
            self._is_plain = self._tls.server_side and self._first_byte() == _MAGIC_BYTE
            if not self._is_plain:
                self._tls.do_handshake()
        except OSError as error:
            raise ProtocolError(ErrorCode.PAIRING, _refusal(error)) from error
        if self._is_plain:
            raise ProtocolError(ErrorCode.PAIRING, _PLAINTEXT)
        if self._tls.selected_alpn_protocol() != ALPN:
            raise ProtocolError(ErrorCode.PAIRING, f"it does not speak {ALPN}")
        with self._lock:
            self._tls.setblocking(False)
            self._is_open = True
        certificate = self._tls.getpeercert(binary_form=True)
        return fingerprint(certificate) if certificate else None

    def _first_byte(self) -> bytes:
        return _peek(self._tls, 1, socket.MSG_PEEK)

    def mark(self, traffic_class: int) -> None:
        mark(self._tls, traffic_class)

    def set_timeout(self, seconds: float) -> None:
        self._timeout_ms = seconds * 1000

    def receive(self, into: memoryview) -> int:
        filled, length = 0, len(into)
        while filled < length and (count := self.receive_available(into[filled:])):
            filled += count
        return filled

    def receive_available(self, into: memoryview) -> int:
        while True:
            try:
                with self._lock:
                    count = 0 if self._has_ended else self._tls.recv_into(into)
            except ssl.SSLWantReadError:
                self._wait(self._readable)
            except ssl.SSLError as error:
                raise OSError(error.errno, f"broken TLS: {error.reason}") from error
            else:
                if self._has_ended:
                    self.discard()
                return count

    def _wait(self, poll: select.poll) -> None:
        if not poll.poll(self._timeout_ms):
            raise TimeoutError("the peer is silent")

    def send(self, data: bytes) -> bool:
        if self._is_plain:
            return _send_raw(self._tls, data, socket.MSG_DONTWAIT) == len(data)
        return not self._is_open or not self._write(data)

    def send_all(self, data: bytes | memoryview) -> None:
        while data := self._write(data):
            self._wait(self._writable)

    def _write(self, data: bytes | memoryview) -> bytes | memoryview:
        """Writes `data` and returns the rest that the send buffer has no room for."""
        with self._lock, suppress(ssl.SSLWantWriteError):
            while data:
                data = data[self._tls.write(data) :]
        return data

    def unacknowledged(self) -> int:
        return unacknowledged(self._tls)

    def least_round_trip_s(self) -> float:
        return least_round_trip_s(self._tls)

    def end_output(self) -> None:
        with self._lock:
            self._has_ended = True
            if self._is_open:
                with suppress(OSError, ValueError):  # the peer may still be sending
                    self._tls.unwrap()
        _shutdown(self._tls, socket.SHUT_WR)

    def end(self) -> None:
        _shutdown(self._tls, socket.SHUT_RDWR)

    def discard(self) -> None:
        scratch = bytearray(_SCRATCH_BYTES)
        while self._readable.poll() and _receive_raw(self._tls, scratch):
            pass

    def abort(self) -> None:
        with suppress(OSError):  # the peer may have disconnected
            _shutdown(self._tls, socket.SHUT_RDWR)

    def close(self) -> None:
        self._tls.close()


def _refusal(error: OSError) -> str:
    if isinstance(error, ssl.SSLError) and error.reason:
        return _REFUSALS.get(error.reason, f"the TLS handshake failed: {error.reason}")
    return "it left the TLS handshake"
