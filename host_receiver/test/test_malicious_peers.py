"""Malicious peers do not disturb the session of a paired device."""

import resource
import select
import socket
import ssl
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import replace
from typing import NoReturn

import pytest

from ml2_receiver.session.report import State
from ml2_receiver.wire.frame import encode_frame
from ml2_receiver.wire.kinds import Kind
from mock_device import MockDevice
from scene import PATIENT
from secure_receiver import LIMITS, QUICK, UNPAIRED_ADDRESS, OpenLab, SecureReceiver, refused
from tls_device import anonymous_context
from waiting import LIMIT_S


def test_peers_that_stop_in_the_handshake_are_closed_in_time(open_lab: OpenLab) -> None:
    secure = open_lab(QUICK)
    hello = client_hello(secure)
    with secure.streaming(), ExitStack() as stack:
        slow = [stack.enter_context(secure.connect()) for _ in range(3)]
        for peer, sent in zip(slow, (b"", hello[:40], hello), strict=True):
            peer.sendall(sent)
        for peer in slow:
            with suppress(ConnectionError):
                while peer.recv(10_000):
                    pass
        secure.await_more()
    secure.sink.await_event("timeout: no HELLO or JOIN within 1.0 s")


def test_a_byte_now_and_then_does_not_extend_the_handshake(open_lab: OpenLab) -> None:
    secure = open_lab(QUICK)
    hello = client_hello(secure)
    with secure.streaming(), secure.connect() as peer, pytest.raises(ConnectionError):
        send_slowly(peer, hello)
    secure.sink.await_event("timeout: no HELLO or JOIN within 1.0 s")


def send_slowly(peer: socket.socket, text: bytes) -> None:
    for byte in text:
        peer.sendall(bytes([byte]))
        time.sleep(0.05)  # a slow peer, whom nothing tells when to go on


def client_hello(secure: SecureReceiver) -> bytes:
    incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
    tls = secure.certificate("slow").context().wrap_bio(incoming, outgoing)
    with pytest.raises(ssl.SSLWantReadError):
        tls.do_handshake()
    return outgoing.read()


@pytest.fixture
def many_files() -> Iterator[None]:
    """This process may have 4096 open files: a user's limit is often 1024."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, 4096)), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.mark.usefixtures("many_files")
def test_a_thousand_half_open_connections_do_not_disturb_a_session(open_lab: OpenLab) -> None:
    secure = open_lab(PATIENT)
    with secure.streaming() as streaming, ExitStack() as stack:
        threads = threading.active_count()
        for _ in range(1000):
            stack.enter_context(secure.connect())
        assert threading.active_count() <= threads + 16 + 64
        secure.await_more(50)
        secure.sink.await_event(f"{UNPAIRED_ADDRESS} is turned away: ")
        with MockDevice(secure.server.address, tls=streaming.device.tls) as back:
            back.start()  # from another address than the thousand


def test_who_fails_too_often_has_to_wait(open_lab: OpenLab) -> None:
    secure = open_lab(replace(LIMITS, failed_attempts=3, failed_attempts_per_s=0.001))
    context = secure.paired("headset").context()
    turned_away = f"{UNPAIRED_ADDRESS} is turned away: too many failed attempts"
    # More than three, since a peer knows of its refusal before it is counted
    while not any(turned_away in event for event in secure.sink.events):
        refused(lambda: anonymous_context().wrap_socket(secure.connect()))
    refused(lambda: context.wrap_socket(secure.connect()))
    with MockDevice(secure.server.address, tls=context) as device:
        device.connect()  # from elsewhere


def test_strangers_of_its_own_address_do_not_keep_a_paired_headset_out(open_lab: OpenLab) -> None:
    secure = open_lab(PATIENT)
    context = secure.paired("headset").context()

    def leave() -> None:
        with MockDevice(secure.server.address, tls=context) as device:
            device.start()
            device.leave()

    leave()
    for _ in range(30):
        connection = socket.create_connection(secure.address, LIMIT_S)
        refused(lambda: anonymous_context().wrap_socket(connection))  # noqa: B023
    leave()


def test_one_address_has_so_many_connections(open_lab: OpenLab) -> None:
    secure = open_lab(replace(PATIENT, connections_per_address=4))
    with ExitStack() as stack:
        for _ in range(4):
            stack.enter_context(secure.connect())
        with secure.connect() as fifth, suppress(ConnectionError):
            assert fifth.recv(1) == b""
        secure.sink.await_event(f"{UNPAIRED_ADDRESS} is turned away: it has 4 connections")


def test_a_lane_that_is_cut_into_by_the_network_ends_the_session(secure: SecureReceiver) -> None:
    with MockDevice(secure.server.address, tls=secure.paired("headset").context()) as device:
        device.start()
        tls = device.wires["world_left"].socket
        raw = socket.socket(fileno=tls.detach())
        raw.sendall(b"\x17\x03\x03\x00\x40" + b"x" * 0x40)
        device.wires.pop("world_left")
        device.wires["control"].expect_end()
        raw.close()
    assert secure.sink.await_report().state is State.LOST
    secure.sink.await_event("broken TLS: ")


@pytest.mark.parametrize("is_encrypted", [True, False])
def test_a_peer_that_does_not_read_is_cut_off(secure: SecureReceiver, is_encrypted: bool) -> None:
    host, port = secure.address if is_encrypted else secure.insecure()
    tls = secure.paired("headset").context() if is_encrypted else None
    with MockDevice(f"{host}:{port}", tls=tls) as device:
        device.start()
        control = device.wires["control"].socket
        with pytest.raises(OSError, match=r"EOF|reset|pipe|timed out|SYS"):
            send_endlessly(control, encode_frame(Kind.PING) * 1000)
    assert secure.sink.await_report().state is State.LOST


@pytest.mark.parametrize("is_encrypted", [True, False])
def test_replies_that_are_not_read_wait_and_the_session_goes_on(
    secure: SecureReceiver, is_encrypted: bool
) -> None:
    host, port = secure.address if is_encrypted else secure.insecure()
    tls = secure.paired("headset").context() if is_encrypted else None
    with MockDevice(f"{host}:{port}", says_ping=True, tls=tls) as device:
        device.start()
        lane = device.wires["time"]
        lane.socket.setblocking(False)
        request = encode_frame(Kind.TIME_REQUEST, bytes(8))
        unsent, written = memoryview(request * 1_000_000), 0
        writable = select.poll()  # select() takes no file above 1023
        writable.register(lane.socket, select.POLLOUT)
        while writable.poll(1000):
            with suppress(BlockingIOError, ssl.SSLWantWriteError):
                written += lane.socket.send(unsent[written:][:16_000])
        assert 0 < written < len(unsent), "it never waited"
        lane.socket.settimeout(LIMIT_S)
        whole = written // len(request)
        for _ in range(whole):
            lane.expect(Kind.TIME_REPLY)
        device.wires["sensors"].send(Kind.DATA, bytes(4))
        secure.sink.await_event("DATA of channel 0")


def send_endlessly(to: socket.socket, data: bytes) -> NoReturn:
    while True:
        to.sendall(data)
