"""Pairing over the wire, by a device that is played by hand."""

import base64
import errno
import json
import socket
import ssl
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from itertools import chain, count, repeat
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256

from ml2_receiver.pairing import listener as pairing_listener
from ml2_receiver.pairing.listener import PairingListener
from ml2_receiver.pairing.pairing import Pairing
from ml2_receiver.security.identity import Identity
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_receiver.transport.listener import listen
from test_viewing_connections import fail_to_accept
from tls_device import Certificate, anonymous_context
from waiting import LIMIT_S, await_true

HEADER = struct.Struct("<HBBHHIIqq")
CHALLENGE, PAIR, PAIRED, ERROR = 60, 61, 62, 51
EXCHANGE_S = 20.0  # a busy machine may need it


class PairingScene:
    def __init__(self, folder: Path) -> None:
        identity = Identity.of(folder / "keys")
        self.fingerprint = identity.fingerprint
        self.devices = PairedDevices(folder / "keys")
        self.pairing = Pairing(identity.fingerprint)
        self.said: list[str] = []
        listener = listen(("127.0.0.1", 0))
        self.address = listener.getsockname()[:2]
        self.listener = PairingListener(
            listener,
            identity,
            self.devices,
            self.pairing,
            name="desk",
            software="test 1",
            sessions_port=7755,
            say=self.said.append,
        )
        self.certificate = Certificate(folder / "device", "device")

    def connect(self, context: ssl.SSLContext | None = None) -> ssl.SSLSocket:
        bare = socket.create_connection(self.address, LIMIT_S)
        return (context or anonymous_context()).wrap_socket(bare)

    def answer(self, nonce: str, **changes: Any) -> dict[str, Any]:
        """A good PAIR, but for `changes`."""
        signed = f"ml2s pair 1\n{self.fingerprint}\n{nonce}\n{self.pairing.token}".encode()
        return {
            "token": self.pairing.token,
            "name": "Magic Leap 2",
            "device_id": "id",
            "certificate": base64.b64encode(self.certificate.der).decode(),
            "signature": base64.b64encode(
                self.certificate.key.sign(signed, ec.ECDSA(SHA256()))
            ).decode(),
        } | changes

    def pair(self, **changes: Any) -> tuple[int, Any]:
        """Kind and body of what comes after PAIR."""
        with self.connect() as tls:
            kind, challenge = read(tls)
            assert kind == CHALLENGE
            send(tls, PAIR, self.answer(challenge["nonce"], **changes))
            answer = read(tls)
            assert tls.recv(1) == b""
        return answer


def send(tls: socket.socket, kind: int, body: Any) -> None:
    data = json.dumps(body).encode()
    tls.sendall(HEADER.pack(0x324D, 1, kind, 0, 0, 0, len(data), 0, 0) + data)


def read(tls: socket.socket) -> tuple[int, Any]:
    header = HEADER.unpack(exactly(tls, 32))
    return header[2], json.loads(exactly(tls, header[6]))


def exactly(tls: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count:
        more = tls.recv(count - len(data))
        assert more, data
        data += more
    return data


def clock(times_s: Iterator[float]) -> SimpleNamespace:
    """Time for the next connection: one of these moments each time that it is asked for."""
    return SimpleNamespace(monotonic=times_s.__next__, time_ns=time.time_ns)


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[PairingScene]:
    monkeypatch.setattr(pairing_listener, "_EXCHANGE_S", EXCHANGE_S)
    scene = PairingScene(tmp_path)
    yield scene
    scene.listener.close()
    assert scene.pairing.token not in "\n".join(scene.said)


def test_the_device_with_the_token_is_paired(scene: PairingScene) -> None:
    assert scene.pair() == (PAIRED, {"name": "desk", "port": 7755})
    assert scene.listener.ended.wait(LIMIT_S)
    (device,) = scene.devices.load()
    assert (device.name, device.device_id) == ("Magic Leap 2", "id")
    assert device.certificate == scene.certificate.der
    assert scene.listener.device == device


def test_a_device_that_cannot_be_remembered_is_told_and_pairing_ends(
    scene: PairingScene, tmp_path: Path
) -> None:
    (tmp_path / "keys" / "devices").write_text("in the way")
    kind, error = scene.pair()
    assert (kind, error["code"]) == (ERROR, "pairing")
    assert "cannot store the pairing" in error["message"]
    assert scene.listener.ended.wait(LIMIT_S)
    assert "cannot use" in str(scene.listener.failure)
    assert scene.listener.device is None


def test_the_challenge_is_signed_by_nothing_but_tls_with_the_shown_certificate(
    scene: PairingScene,
) -> None:
    with scene.connect() as tls:
        certificate = tls.getpeercert(binary_form=True)
        assert certificate is not None
        assert tls.version() == "TLSv1.3"
        _, challenge = read(tls)
    with scene.connect() as tls:
        assert read(tls)[1]["nonce"] != challenge["nonce"]
    assert (challenge["name"], challenge["software"]) == ("desk", "test 1")
    assert len(bytes.fromhex(challenge["nonce"])) == 32


def test_a_token_that_was_used_is_refused(scene: PairingScene, tmp_path: Path) -> None:
    scene.pair()
    scene.certificate = Certificate(tmp_path / "second", "second")
    kind, error = scene.pair()
    assert (kind, error["code"], error["fatal"]) == (ERROR, "pairing", True)
    assert "used or expired" in error["message"]
    assert len(scene.devices.load()) == 1


def test_an_answer_to_another_connections_challenge_is_refused(scene: PairingScene) -> None:
    with scene.connect() as heard, scene.connect() as replayed:
        answer = scene.answer(read(heard)[1]["nonce"])
        read(replayed)
        send(replayed, PAIR, answer)
        kind, error = read(replayed)
    assert (kind, error["code"], error["message"]) == (ERROR, "pairing", "wrong signature")
    assert scene.devices.load() == []


def test_wrong_tokens_are_counted_and_told(scene: PairingScene) -> None:
    for _ in range(5):
        kind, error = scene.pair(token="0" * 32)
        assert (kind, error["code"]) == (ERROR, "pairing")
    assert scene.pairing.is_guessed_at
    assert scene.pair()[0] == ERROR
    assert scene.devices.load() == []
    # It is told once the device has closed its connection.
    await_true(lambda: any("wrong token, 0 more allowed" in it for it in scene.said))


@pytest.mark.parametrize(
    ("sent", "code"),
    [
        (HEADER.pack(0x324D, 1, PAIR, 0, 0, 0, 16385, 0, 0), "too_large"),
        (HEADER.pack(0x324D, 1, PAIR, 0, 0, 0, 0xFFFFFFFF, 0, 0), "too_large"),
        (HEADER.pack(0x324D, 2, PAIR, 0, 0, 0, 0, 0, 0), "version"),
        (HEADER.pack(0x324D, 1, PAIR, 0, 0, 0, 2, 0, 0) + b"{}", "malformed"),
        (HEADER.pack(0x324D, 1, PAIR, 0, 0, 0, 9000, 0, 0) + b"[" * 9000, "malformed"),
        (HEADER.pack(0x324D, 1, 1, 0, 0, 0, 2, 0, 0) + b"{}", "unexpected"),
        (HEADER.pack(0x324D, 1, 16, 0, 0, 0, 2, 0, 0) + b"{}", "unexpected"),
        (HEADER.pack(0x324D, 1, 200, 0, 0, 0, 2, 0, 0) + b"{}", "unexpected"),
        (HEADER.pack(0x324D, 1, PAIR, 0, 0, 0, 100, 0, 0) + b"{", "timeout"),
        (b"", "timeout"),
        (b"\0" * 100, "malformed"),
    ],
)
def test_malicious_peers_are_refused_and_the_next_device_is_paired(
    scene: PairingScene, sent: bytes, code: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        if code == "timeout":  # as soon as PAIR is awaited
            patch.setattr(pairing_listener, "time", clock(chain([0], repeat(EXCHANGE_S))))
        with scene.connect() as tls:
            read(tls)
            tls.sendall(sent)
            kind, error = read(tls)
    assert (kind, error["code"]) == (ERROR, code)
    assert scene.pair()[0] == PAIRED


def tls_12() -> ssl.SSLContext:
    context = anonymous_context()
    context.minimum_version = context.maximum_version = ssl.TLSVersion.TLSv1_2
    return context


def other_protocol() -> ssl.SSLContext:
    context = anonymous_context()
    context.set_alpn_protocols(["http/1.1"])
    return context


@pytest.mark.parametrize("context", [tls_12, other_protocol])
def test_other_protocols_are_refused(
    scene: PairingScene, context: Callable[[], ssl.SSLContext]
) -> None:
    with suppress(ssl.SSLError), scene.connect(context()) as tls:
        assert read(tls)[0] == ERROR
    assert scene.pair()[0] == PAIRED


def test_plaintext_and_silence_do_not_keep_a_device_out(
    scene: PairingScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    with ExitStack() as stack:
        with monkeypatch.context() as patch:
            patch.setattr(pairing_listener, "_EXCHANGE_S", 1.0)
            silent, plain = (
                stack.enter_context(socket.create_connection(scene.address, LIMIT_S))
                for _ in range(2)
            )
            send(plain, PAIR, {})
            await_true(lambda: bool(scene.said))  # so the limit of both is the shorter one
        assert scene.pair()[0] == PAIRED
        with suppress(ConnectionError):
            assert silent.recv(100) == b""


def test_bytes_now_and_then_do_not_hold_a_place(
    scene: PairingScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Two seconds pass from one look at the clock to the next, whether bytes come or not.
    monkeypatch.setattr(pairing_listener, "time", clock(count(0, EXCHANGE_S / 10)))
    with scene.connect() as tls:
        read(tls)
        tls.sendall(HEADER.pack(0x324D, 1, PAIR, 0, 0, 0, 9000, 0, 0))
        with pytest.raises((ConnectionError, ssl.SSLError)):
            send_slowly(tls)


def send_slowly(tls: socket.socket) -> None:
    for _ in range(400):
        tls.sendall(b" ")
        time.sleep(0.1)  # a slow peer, whom nothing tells when to go on


def test_silent_connections_do_not_keep_a_device_of_another_machine_out(
    scene: PairingScene,
) -> None:
    unpaired = ("127.0.0.2", 0)
    with ExitStack() as stack:
        held = [
            stack.enter_context(socket.create_connection(scene.address, LIMIT_S, unpaired))
            for _ in range(40)
        ]
        assert scene.pair()[0] == PAIRED
        with suppress(ConnectionError):
            assert held[0].recv(1) == b""


@pytest.mark.parametrize("hosts", [["127.0.0.2"], [f"127.0.1.{it}" for it in range(1, 251)]])
def test_a_flood_of_connections_is_bounded_before_the_handshake(
    scene: PairingScene, hosts: list[str]
) -> None:
    threads = threading.active_count()
    with ExitStack() as stack:
        held = [
            stack.enter_context(socket.create_connection(scene.address, LIMIT_S, (host, 0)))
            for host in hosts * (500 // len(hosts))
        ]
        # So many at a time, the newest of them; the others are closed without having said anything.
        for connection in held[: -pairing_listener._CONNECTIONS]:
            connection.settimeout(LIMIT_S)
            with suppress(ConnectionError):
                assert connection.recv(1) == b""
        await_true(lambda: threading.active_count() <= threads + pairing_listener._CONNECTIONS)
        assert scene.pair()[0] == PAIRED


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ECONNABORTED])
def test_it_goes_on_accepting(
    scene: PairingScene, number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    failures = fail_to_accept(monkeypatch, number)
    assert scene.pair()[0] == PAIRED  # by a call of accept() that had begun before
    await_true(lambda: len(failures) == 3)
    with scene.connect() as tls:
        assert read(tls)[0] == CHALLENGE
