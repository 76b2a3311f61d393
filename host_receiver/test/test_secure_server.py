"""Tests which headsets are let in, and what others see of it."""

import secrets
import socket
import ssl
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

import test_pairing_listener
from ml2_receiver.session.report import State
from ml2_receiver.transport.access import PairedOnly
from ml2_receiver.transport.listener import listen
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, encode_frame
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import Bye, Join
from ml2_receiver.wire.opening_bodies import Open
from mock_device import MockDevice, Wire
from secure_receiver import UNPAIRED_ADDRESS, SecureReceiver, refused
from tls_device import Certificate, anonymous_context
from waiting import await_true

IMAGE = "world_left/image_raw"


def test_a_paired_device_streams_over_tls_and_payloads_arrive_unchanged(
    secure: SecureReceiver,
) -> None:
    sent = [
        CDR_ENCAPSULATION + bytes([it]) * size for it, size in enumerate((0, 5, 16_384, 3 << 20))
    ]
    with MockDevice(secure.server.address, tls=secure.paired("headset").context()) as device:
        device.start()
        for payload in sent:
            device.publish(IMAGE, payload)
        assert secure.sink.await_payloads(IMAGE, len(sent)) == sent
        device.leave()
    report = secure.sink.await_report()
    assert (report.state, report.is_final) == (State.ENDED, True)


def test_an_app_gets_messages_over_tls_and_may_leave_without_reading(
    secure: SecureReceiver,
) -> None:
    headset = secure.paired("headset")

    def writers() -> int:
        return sum(it.name == "ros-writer" for it in threading.enumerate())

    for is_read in (True, False):
        app = MockDevice(secure.server.address, has_ros=True, tls=headset.context())
        with app:
            app.start()
            name = f"/{is_read}"
            wanted = Open(1, "subscription", name, "T", keep="all", depth=100)
            assert app.open(wanted).result == "opened"
            queue = secure.graph.queues[1]
            payloads = [CDR_ENCAPSULATION + secrets.token_bytes(60_000) for _ in range(3)]
            if is_read:
                for payload in payloads:
                    queue.put(payload, 5)
                assert [app.message()[1] for _ in payloads] == payloads
            else:
                while not queue.book.dropped["queue_full"]:
                    queue.put(payloads[0], 5)
                app.exchange_time(1)
            assert writers() == 1
    await_true(lambda: not writers())
    await_true(lambda: not queue.book.waiting)
    assert queue.book.dropped["link_down"]


def test_headsets_whose_certificates_have_the_same_name_can_all_connect(
    secure: SecureReceiver,
) -> None:
    for number in range(3):
        same = Certificate(secure.folder / str(number), "ML2 Sensors")
        secure.devices.add("headset", str(number), same.der)
        with MockDevice(secure.server.address, str(number), tls=same.context()) as device:
            device.start()
            device.leave()


def test_everything_is_tls_13(secure: SecureReceiver) -> None:
    wire = Wire(secure.server.address, "control", secure.paired("headset").context())
    assert isinstance(wire.socket, ssl.SSLSocket)
    assert wire.socket.version() == "TLSv1.3"
    assert wire.socket.selected_alpn_protocol() == "ml2s/1"
    wire.socket.close()


@pytest.mark.skipif(not socket.has_dualstack_ipv6(), reason="this machine has no IPv6")
@pytest.mark.parametrize(
    ("listening", "to", "seen"),
    [("::1", "::1", "[::1]"), ("::", "::1", "[::1]"), ("::", "127.0.0.1", "127.0.0.1")],
)
def test_a_headset_comes_by_ipv6_as_by_ipv4(
    secure: SecureReceiver, listening: str, to: str, seen: str
) -> None:
    server_host, port = secure.serve(PairedOnly(secure.folder / "keys"), listening)
    assert server_host == f"[{listening}]"
    context = secure.paired("headset").context()
    address = f"[{to}]:{port}" if ":" in to else f"{to}:{port}"
    with MockDevice(address, tls=context) as device:
        device.start()
        secure.sink.await_event(f"connected from {seen}:")


class Relay:
    """Forwards one connection after the other to a receiver, and keeps every byte."""

    def __init__(self, target: tuple[str, int]) -> None:
        self.heard = bytearray()
        self._target = target
        self._listener = listen(("127.0.0.1", 0))
        self.address = "{}:{}".format(*self._listener.getsockname())
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                device, _ = self._listener.accept()
                receiver = socket.create_connection(self._target)
                for source, sink in ((device, receiver), (receiver, device)):
                    threading.Thread(target=self._carry, args=[source, sink], daemon=True).start()

    def _carry(self, source: socket.socket, sink: socket.socket) -> None:
        with suppress(OSError), source, sink:
            while data := source.recv(1 << 16):
                self.heard += data
                sink.sendall(data)

    def close(self) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()


@pytest.mark.parametrize("is_encrypted", [True, False])
def test_who_listens_sees_no_pixel_row_token_or_topic_name(
    secure: SecureReceiver, is_encrypted: bool
) -> None:
    rows = [bytes([(number * 7 + x) % 251 for x in range(1016)]) for number in range(100)]
    target = secure.address if is_encrypted else secure.insecure()
    relay = Relay(target)
    tls = secure.paired("headset").context() if is_encrypted else None
    with MockDevice(relay.address, tls=tls) as device:
        device.start()
        device.publish(IMAGE, CDR_ENCAPSULATION + b"".join(rows))
        secure.sink.await_payloads(IMAGE, 1)
        secrets = [
            device.welcome.session,
            *device.welcome.tickets.values(),
            *(f'"{topic.name}"' for topic in device.device.announced),
        ]
        # None is so short that 100 kB of cipher text have it by chance.
        header = encode_frame(Kind.HELLO, b"")[:6]
        words = [*rows, *(it.encode() for it in secrets), header, b"device name"]
    relay.close()
    heard = bytes(relay.heard)
    assert len(heard) > sum(map(len, rows))
    seen = [word for word in words if word in heard]
    used = {it.encode() for it in device.welcome.tickets.values()}
    assert seen == [] if is_encrypted else {*words} - {*seen} <= used


Damage = Callable[[SecureReceiver], object]


@pytest.mark.parametrize(
    "damage",
    [
        lambda secure: secure.devices.add("bad", "id", b"0"),  # OpenSSL does not take it
        lambda secure: (secure.folder / f"keys/devices/{'0' * 64}.json").write_text("{}"),
    ],
)
def test_a_damaged_device_keeps_only_itself_out(secure: SecureReceiver, damage: Damage) -> None:
    with secure.streaming():
        damage(secure)
        secure.await_more()
        with MockDevice(secure.server.address, tls=secure.paired("other").context()) as other:
            other.greet().expect_error("busy")
        secure.await_more()


def with_changed_certificate(secure: SecureReceiver) -> ssl.SSLContext:
    return Certificate(secure.folder / "other", "headset").context()


def with_tls_12(secure: SecureReceiver) -> ssl.SSLContext:
    old = secure.paired("old").context()
    old.minimum_version = old.maximum_version = ssl.TLSVersion.TLSv1_2
    return old


def with_another_protocol(secure: SecureReceiver) -> ssl.SSLContext:
    other = secure.paired("other").context()
    other.set_alpn_protocols(["http/1.1"])
    return other


@pytest.mark.parametrize(
    ("context", "alert", "logged"),
    [
        (with_changed_certificate, "UNKNOWN_CA", "it is not paired: run `ml2-receiver pair`"),
        (lambda _: anonymous_context(), "", "it shows no certificate"),
        (with_tls_12, "", "it does not speak TLS 1.3"),
        (with_another_protocol, "", "it does not speak ml2s/1"),
    ],
)
def test_an_unacceptable_handshake_is_refused_and_the_session_goes_on(
    secure: SecureReceiver,
    context: Callable[[SecureReceiver], ssl.SSLContext],
    alert: str,
    logged: str,
) -> None:
    tls = context(secure)
    with secure.streaming():
        assert alert in refused(lambda: tls.wrap_socket(secure.connect()))
        secure.await_more()
    secure.sink.await_event(f"(new connection): pairing: {logged}")


def test_a_certificate_that_a_paired_device_has_signed_is_refused(secure: SecureReceiver) -> None:
    authority = secure.certificate("authority", is_authority=True)
    secure.devices.add("authority", "authority", authority.der)
    forged = secure.certificate("forged", issuer=authority)
    with secure.streaming():
        wire = Wire(secure.server.address, "control", forged.context(), UNPAIRED_ADDRESS)
        wire.expect_error("pairing")
        secure.await_more()
        wire.socket.close()
    secure.sink.await_event("pairing: it is not paired")


def test_plaintext_is_answered_in_words(secure: SecureReceiver) -> None:
    with secure.streaming(), MockDevice(secure.server.address, "plain") as plain:
        error = plain.greet().expect_error("pairing")
        secure.await_more()
    assert "this port speaks TLS only" in error.message
    secure.sink.await_event("pairing: this port speaks TLS only")


@pytest.mark.parametrize("sent", [b"GET / HTTP/1.1\r\n\r\n", b"\x16\x03\x01" + b"\xff" * 5000, b""])
def test_what_is_no_handshake_is_refused(secure: SecureReceiver, sent: bytes) -> None:
    with secure.streaming(), secure.connect() as peer:
        peer.sendall(sent)
        peer.shutdown(socket.SHUT_WR)
        with suppress(ConnectionError):
            while peer.recv(1000):
                pass
        secure.await_more()
    secure.sink.await_event("pairing: ")


def test_a_ticket_is_worth_nothing_on_the_connection_of_another_paired_device(
    secure: SecureReceiver,
) -> None:
    thief = secure.paired("thief").context()
    with MockDevice(secure.server.address, tls=secure.paired("headset").context()) as device:
        welcome = device.connect()
        stolen = Join(welcome.session, welcome.tickets["sensors"], "sensors")
        wire = Wire(secure.server.address, "sensors", thief, UNPAIRED_ADDRESS)
        wire.send(Kind.JOIN, stolen)
        assert wire.expect_error("ticket").message == "the session is another device's"
        wire.socket.close()
        device.join("sensors")
    said = "\n".join(secure.sink.events)
    assert welcome.session not in said
    assert stolen.ticket not in said


def test_a_device_id_does_not_take_another_devices_session(secure: SecureReceiver) -> None:
    with (
        secure.streaming(),
        MockDevice(secure.server.address, tls=secure.paired("thief").context()) as thief,
    ):
        thief.greet().expect_error("busy")
        secure.await_more()


def test_pairing_disturbs_no_session_whoever_tries(secure: SecureReceiver, tmp_path: Path) -> None:
    with secure.streaming():
        pairing = test_pairing_listener.PairingScene(secure.folder)
        answers = [
            pairing.pair(**changes)[0] for changes in ({"token": "0" * 32}, {"signature": ""}, {})
        ]
        pairing.certificate = secure.certificate("thief")
        answers.append(pairing.pair()[0])
        pairing.listener.close()
        assert answers == [Kind.ERROR, Kind.ERROR, Kind.PAIRED, Kind.ERROR]
        secure.await_more()


def test_unpairing_ends_the_running_session_and_keeps_the_device_out(
    secure: SecureReceiver,
) -> None:
    certificate = secure.paired("headset")
    context = certificate.context()
    with MockDevice(secure.server.address, tls=context) as device:
        device.start()
        resumable = device.wires["control"].socket
        assert isinstance(resumable, ssl.SSLSocket)
        session = resumable.session
        secure.devices.remove("headset")
        assert Bye.parse(device.wires["control"].expect(Kind.BYE)).reason == "unpaired"
        for wire in device.wires.values():
            wire.expect_end()
    assert secure.sink.await_report().state is State.ENDED
    secure.sink.await_event("the device was unpaired")
    assert session is not None
    assert session.has_ticket
    refused(lambda: context.wrap_socket(secure.connect(), session=session))


def test_a_device_that_is_paired_while_the_receiver_runs_is_let_in(secure: SecureReceiver) -> None:
    late = secure.certificate("late")
    refused(lambda: late.context().wrap_socket(secure.connect()))
    secure.devices.add("late", "late", late.der)
    with MockDevice(secure.server.address, tls=late.context()) as device:
        device.start()


def test_a_lane_resumes_the_tls_session_of_its_device(secure: SecureReceiver) -> None:
    context = secure.paired("headset").context()
    with MockDevice(secure.server.address, tls=context) as device:
        device.start()
        first = device.wires["control"].socket
        assert isinstance(first, ssl.SSLSocket)
        resumed = context.wrap_socket(
            socket.create_connection(secure.address), session=first.session
        )
        with resumed:
            assert resumed.session_reused
            resumed.sendall(encode_frame(Kind.JOIN, b"{}"))
            assert resumed.recv(4)[3] == Kind.ERROR  # and not a TLS alert
