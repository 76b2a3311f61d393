"""The sockets and threads of a Pairing."""

import socket
import ssl
import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress

from ..errors import ErrorCode, KeysError, ProtocolError
from ..security.contexts import ALPN, pairing_context
from ..security.identity import Identity
from ..security.paired_devices import PairedDevice, PairedDevices
from ..transport.listener import peer_host
from ..wire.frame import FrameParser, encode_frame
from ..wire.json_body import JsonBody
from ..wire.kinds import PAIRING, Kind, Side
from ..wire.messages import Error
from ..wire.pairing_bodies import Pair, PairChallenge, Paired
from .pairing import Pairing

_EXCHANGE_S = 5.0
_LINGER_S = 1.0
_CONNECTIONS = 16
_POLL_S = 0.1
_SCRATCH_BYTES = 4096


class PairingListener:
    """A listener that pairs the one device that has the token, until close().

    Args:
        listener: the listening socket; close() closes it.
        sessions_port: the port that the device connects to after pairing.
        say: logs the address and the reason of each failed attempt, without secrets. Calls do not
            overlap.

    Attributes:
        ended: set when `device` is paired, or when storing it ended in `failure`.
    """

    def __init__(
        self,
        listener: socket.socket,
        identity: Identity,
        devices: PairedDevices,
        pairing: Pairing,
        *,
        name: str,
        software: str,
        sessions_port: int,
        say: Callable[[str], None],
    ) -> None:
        self.ended = threading.Event()
        self.device: PairedDevice | None = None
        self.failure: KeysError | None = None
        self._listener, self._devices, self._pairing = listener, devices, pairing
        self._log_line = say
        self._context = pairing_context(identity)
        self._name, self._software, self._port = name, software, sessions_port
        self._lock = threading.Lock()
        self._open: dict[ssl.SSLSocket, str] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._accept, name="pair", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stops listening; open connections end by themselves within seconds."""
        self._closing.set()
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._listener.close()

    def _accept(self) -> None:
        while not self._closing.is_set():
            try:
                accepted, address = self._listener.accept()
            except OSError:
                self._closing.wait(_POLL_S)
                continue
            try:
                accepted.settimeout(_EXCHANGE_S)
                tls = self._context.wrap_socket(
                    accepted, server_side=True, do_handshake_on_connect=False
                )
            except OSError:
                accepted.close()  # the peer has disconnected already
                continue
            host = peer_host(address[0])
            self._add_connection(tls, host)
            threading.Thread(target=self._serve, args=[tls, host], daemon=True).start()

    def _add_connection(self, tls: ssl.SSLSocket, host: str) -> None:
        """Adds a connection; if there are too many, closes the oldest of the busiest host."""
        with self._lock:
            if len(self._open) >= _CONNECTIONS:
                counts = Counter(self._open.values())
                oldest = max(self._open, key=lambda it: counts[self._open[it]])
                del self._open[oldest]
                with suppress(OSError):
                    socket.socket.shutdown(oldest, socket.SHUT_RDWR)
            self._open[tls] = host

    def _serve(self, tls: ssl.SSLSocket, host: str) -> None:
        deadline_s = time.monotonic() + _EXCHANGE_S
        try:
            tls.do_handshake()
            self._pair(_Exchange(tls, deadline_s))
        except ProtocolError as error:
            self._log_failure(host, str(error))
        except KeysError as error:
            self.failure = error
            self.ended.set()
        except OSError as error:
            reason = getattr(error, "reason", None) or error.strerror or error
            self._log_failure(host, f"no TLS connection: {reason}")
        finally:
            with self._lock:
                self._open.pop(tls, None)
            tls.close()

    def _log_failure(self, host: str, reason: str) -> None:
        with self._lock:
            self._log_line(f"{host}: {reason}")

    def _pair(self, exchange: "_Exchange") -> None:
        nonce = self._pairing.nonce()
        try:
            if exchange.tls.selected_alpn_protocol() != ALPN:
                raise ProtocolError(ErrorCode.PAIRING, f"expected a device that speaks {ALPN}")
            challenge = PairChallenge(nonce, self._name, self._software)
            exchange.send(Kind.PAIR_CHALLENGE, challenge)
            pair = exchange.receive()
            with self._lock:
                found = self._pairing.judge(pair, nonce)
                self.device = self._devices.add(found.name, found.device_id, found.certificate)
            exchange.send(Kind.PAIRED, Paired(self._name, self._port))
            exchange.finish()
            self.ended.set()
        except KeysError:
            exchange.refuse(ErrorCode.PAIRING, "the receiver cannot store the pairing")
            raise
        except ProtocolError as error:
            exchange.refuse(error.code, error.message)
            raise


class _Exchange:
    """The messages of one connection; `deadline_s` is monotonic time."""

    def __init__(self, tls: ssl.SSLSocket, deadline_s: float) -> None:
        self.tls = tls
        self._deadline_s = deadline_s
        self._parser = FrameParser(Side.DEVICE, PAIRING)

    def send(self, kind: Kind, body: JsonBody) -> None:
        with suppress(OSError):  # the peer may have disconnected
            self.tls.sendall(encode_frame(kind, body.to_bytes(), send_ns=time.time_ns()))

    def receive(self) -> Pair:
        frame = None
        while frame is None:
            self.tls.settimeout(max(0.001, self._deadline_s - time.monotonic()))
            try:
                count = self.tls.recv_into(self._parser.get_buffer())
            except TimeoutError as error:
                message = f"no PAIR within {_EXCHANGE_S} s"
                raise ProtocolError(ErrorCode.TIMEOUT, message) from error
            if not count:
                raise ProtocolError(ErrorCode.PAIRING, "the device left before PAIR")
            frame = self._parser.buffer_updated(count)
        if frame.header.kind != Kind.PAIR:
            raise ProtocolError(ErrorCode.UNEXPECTED, "expected PAIR")
        return Pair.parse(frame.body)

    def refuse(self, code: ErrorCode, message: str) -> None:
        self.send(Kind.ERROR, Error(code, message, fatal=True))
        self.finish()

    def finish(self) -> None:
        """Waits up to 1 s until the peer has read what it was sent and has closed the connection.

        Closing the connection with unread input would reset it.
        """
        deadline_s = time.monotonic() + _LINGER_S
        with suppress(OSError):
            socket.socket.shutdown(self.tls, socket.SHUT_WR)
            while (left_s := deadline_s - time.monotonic()) > 0:
                self.tls.settimeout(left_s)
                if not self.tls.recv(_SCRATCH_BYTES):
                    break
