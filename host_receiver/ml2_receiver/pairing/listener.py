"""Sockets and threads around a Pairing."""

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
from ..wire.frame import FrameParser, Kind, LaneKind, Side, encode_frame
from ..wire.json_body import JsonBody
from ..wire.messages import Error, Pair, PairChallenge, Paired
from .pairing import Pairing

_EXCHANGE_S = 5.0
_LINGER_S = 1.0
_CONNECTIONS = 16
_POLL_S = 0.1
_SCRATCH_BYTES = 4096


class PairingListener:
    """Pairs the one device that has the token; close() ends it.

    Args:
        listener: closed by close().
        sessions_port: where devices are told to connect to afterwards.
        say: is told, one call after the other, what went wrong with whom; never a secret.

    Attributes:
        ended: set once there is a `device`, or a `failure` to remember it.
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
        self._listener, self._devices, self._pairing, self._say = listener, devices, pairing, say
        self._context = pairing_context(identity)
        self._name, self._software, self._port = name, software, sessions_port
        self._lock = threading.Lock()
        self._open: dict[ssl.SSLSocket, str] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._accept, name="pair", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Nobody can connect any more; connections end within seconds, by themselves."""
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
                accepted.close()  # it has left already
                continue
            host = peer_host(address[0])
            self._take_in(tls, host)
            threading.Thread(target=self._serve, args=[tls, host], daemon=True).start()

    def _take_in(self, tls: ssl.SSLSocket, host: str) -> None:
        """If there are too many, the oldest of the machine that has most of them has to go."""
        with self._lock:
            if len(self._open) >= _CONNECTIONS:
                counts = Counter(self._open.values())
                oldest = max(self._open, key=lambda it: counts[self._open[it]])
                del self._open[oldest]
                with suppress(OSError):
                    socket.socket.shutdown(oldest, socket.SHUT_RDWR)
            self._open[tls] = host

    def _serve(self, tls: ssl.SSLSocket, host: str) -> None:
        ends_s = time.monotonic() + _EXCHANGE_S
        try:
            tls.do_handshake()
            self._judge(_Exchange(tls, ends_s))
        except ProtocolError as error:
            self._tell(host, str(error))
        except KeysError as error:
            self.failure = error
            self.ended.set()
        except OSError as error:
            reason = getattr(error, "reason", None) or error.strerror or error
            self._tell(host, f"no TLS connection: {reason}")
        finally:
            with self._lock:
                self._open.pop(tls, None)
            tls.close()

    def _tell(self, host: str, what: str) -> None:
        with self._lock:
            self._say(f"{host}: {what}")

    def _judge(self, exchange: "_Exchange") -> None:
        nonce = self._pairing.nonce()
        try:
            if exchange.tls.selected_alpn_protocol() != ALPN:
                raise ProtocolError(ErrorCode.PAIRING, f"expected a device that speaks {ALPN}")
            challenge = PairChallenge(nonce, self._name, self._software)
            exchange.send(Kind.PAIR_CHALLENGE, challenge)
            pair = exchange.receive()
            with self._lock:
                it = self._pairing.judge(pair, nonce)
                self.device = self._devices.add(it.name, it.device_id, it.certificate)
            exchange.send(Kind.PAIRED, Paired(self._name, self._port))
            exchange.finish()
            self.ended.set()
        except KeysError:
            exchange.refuse(ErrorCode.PAIRING, "the receiver cannot remember it")
            raise
        except ProtocolError as error:
            exchange.refuse(error.code, error.message)
            raise


class _Exchange:
    """One connection, until `ends_s` in monotonic time."""

    def __init__(self, tls: ssl.SSLSocket, ends_s: float) -> None:
        self.tls = tls
        self._ends_s = ends_s
        self._parser = FrameParser(Side.DEVICE, LaneKind.PAIRING)

    def send(self, kind: Kind, body: JsonBody) -> None:
        with suppress(OSError):  # who has left needs no answer
            self.tls.sendall(encode_frame(kind, body.to_bytes(), send_ns=time.time_ns()))

    def receive(self) -> Pair:
        frame = None
        while frame is None:
            self.tls.settimeout(max(0.001, self._ends_s - time.monotonic()))
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
        return Pair.parse(frame.payload)

    def refuse(self, code: ErrorCode, message: str) -> None:
        self.send(Kind.ERROR, Error(code, message, fatal=True))
        self.finish()

    def finish(self) -> None:
        """Lets the peer read what it was sent: a close with bytes unread would be a reset."""
        ends_s = time.monotonic() + _LINGER_S
        with suppress(OSError):
            socket.socket.shutdown(self.tls, socket.SHUT_WR)
            while (left_s := ends_s - time.monotonic()) > 0:
                self.tls.settimeout(left_s)
                if not self.tls.recv(_SCRATCH_BYTES):
                    break
