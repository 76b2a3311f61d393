"""What hostile peers can do, while the session of a paired device goes on."""

import socket
import ssl
import struct
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from typing import NoReturn

import pytest

from ml2_receiver.session.report import State
from ml2_receiver.session.settings import Limits
from ml2_receiver.wire.frame import Kind, encode_frame
from ml2_receiver.wire.messages import Error
from mock_device import MockDevice, Wire
from tls_device import anonymous_context
from tls_lab import QUICK, STRANGER, Lab, refused


def test_peers_that_stop_in_the_handshake_are_closed_in_time(lab: Lab) -> None:
    hello = client_hello(lab)
    with lab.streaming(), ExitStack() as stack:
        slow = [stack.enter_context(lab.connect()) for _ in range(3)]
        for peer, sent in zip(slow, (b"", hello[:40], hello), strict=True):
            peer.sendall(sent)
        for peer in slow:
            while peer.recv(10_000):
                pass
        lab.await_more()
    lab.sink.await_event("timeout: no HELLO or JOIN within 1.0 s")


def test_a_byte_now_and_then_does_not_extend_the_handshake(lab: Lab) -> None:
    hello = client_hello(lab)
    began_s = time.monotonic()
    with lab.streaming(), lab.connect() as peer, suppress(ConnectionError):
        for byte in hello:
            peer.sendall(bytes([byte]))
            time.sleep(0.05)  # a slow peer, whom nothing tells when to go on
    assert time.monotonic() - began_s < 5
    lab.sink.await_event("timeout: no HELLO or JOIN within 1.0 s")


def client_hello(lab: Lab) -> bytes:
    incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
    tls = lab.certificate("slow").context().wrap_bio(incoming, outgoing)
    with pytest.raises(ssl.SSLWantReadError):
        tls.do_handshake()
    return outgoing.read()


def test_a_paired_peer_that_stops_in_the_middle_of_a_frame_is_told_and_closed(lab: Lab) -> None:
    context = lab.paired("other").context()
    with lab.streaming():
        wire = Wire(lab.server.address, "control", context, STRANGER)
        wire.socket.sendall(encode_frame(Kind.HELLO, b"{}")[:-1])
        wire.expect_error("timeout")
        lab.await_more()
        wire.socket.close()


def test_a_thousand_half_open_connections_do_not_disturb_a_session(
    open_lab: Callable[[Limits], Lab],
) -> None:
    lab = open_lab(Limits())
    with lab.streaming() as streaming, ExitStack() as stack:
        threads = threading.active_count()
        for _ in range(1000):
            stack.enter_context(lab.connect())
        assert threading.active_count() <= threads + 16 + 64
        lab.await_more(50)
        lab.sink.await_event(f"{STRANGER} is turned away: ")
        with MockDevice(lab.server.address, tls=streaming.device.tls) as back:
            back.start()  # from another address than the thousand


def test_who_fails_too_often_has_to_wait(open_lab: Callable[[Limits], Lab]) -> None:
    lab = open_lab(replace(QUICK, failed_attempts=3, failed_attempts_per_s=0.5))
    context = lab.paired("headset").context()
    for _ in range(3):
        refused(lambda: anonymous_context().wrap_socket(lab.connect()))
    refused(lambda: context.wrap_socket(lab.connect()))
    lab.sink.await_event(f"{STRANGER} is turned away: too many failed attempts")
    with MockDevice(lab.server.address, tls=context) as device:
        device.connect()  # from elsewhere
    deadline_s = time.monotonic() + 10
    while True:
        try:
            context.wrap_socket(lab.connect()).close()
            return
        except (ssl.SSLError, ConnectionError):
            assert time.monotonic() < deadline_s


def test_strangers_of_its_own_address_do_not_keep_a_paired_headset_out(
    open_lab: Callable[[Limits], Lab],
) -> None:
    lab = open_lab(Limits())
    context = lab.paired("headset").context()

    def leave() -> None:
        with MockDevice(lab.server.address, tls=context) as device:
            device.start()
            device.leave()

    leave()
    for _ in range(30):
        connection = socket.create_connection(lab.address, 5)
        refused(lambda: anonymous_context().wrap_socket(connection))  # noqa: B023
    leave()


def test_one_address_has_so_many_connections(open_lab: Callable[[Limits], Lab]) -> None:
    lab = open_lab(replace(Limits(), connections_per_address=4))
    with ExitStack() as stack:
        for _ in range(4):
            stack.enter_context(lab.connect())
        with lab.connect() as fifth, suppress(ConnectionError):
            assert fifth.recv(1) == b""
        lab.sink.await_event(f"{STRANGER} is turned away: it has 4 connections")


def hostile_frames() -> dict[str, bytes]:
    huge = struct.pack("<HBBHHIIqq", 0x324D, 1, Kind.HELLO, 0, 0, 0, 0xFFFFFFFF, 0, 0)
    deep = b"[" * 30_000
    return {
        "too_large": huge,
        "malformed": encode_frame(Kind.HELLO, deep),
        "malformed ": b"\x00" * 100_000,
    }


@pytest.mark.parametrize("code", hostile_frames())
def test_a_paired_but_hostile_device_is_refused_and_the_session_goes_on(
    lab: Lab, code: str
) -> None:
    context = lab.paired("hostile").context()
    with lab.streaming():
        wire = Wire(lab.server.address, "control", context, STRANGER)
        wire.socket.sendall(hostile_frames()[code])
        assert Error.parse(wire.expect(Kind.ERROR)).code == code.strip()
        lab.await_more()
        wire.socket.close()
    lab.sink.await_event(f"{code.strip()}: ")


def test_bytes_that_are_no_tls_after_the_handshake_end_that_connection(lab: Lab) -> None:
    context = lab.paired("hostile").context()
    with lab.streaming():
        bare = lab.connect()
        tls = context.wrap_socket(bare)
        raw = socket.socket(fileno=tls.detach())
        raw.settimeout(5)
        with raw, suppress(ConnectionError):
            raw.sendall(b"\x17\x03\x03\x40\x00" + b"x" * 0x4000)
            while raw.recv(1000):
                pass
        lab.await_more()
    lab.sink.await_event("broken TLS: ")


def test_a_lane_that_is_cut_into_by_the_network_ends_the_session(lab: Lab) -> None:
    with MockDevice(lab.server.address, tls=lab.paired("headset").context()) as device:
        device.start()
        tls = device.wires["world_left"].socket
        raw = socket.socket(fileno=tls.detach())
        raw.sendall(b"\x17\x03\x03\x00\x40" + b"x" * 0x40)
        device.wires.pop("world_left")
        device.wires["control"].expect_end()
        raw.close()
    assert lab.sink.await_report().state is State.LOST
    lab.sink.await_event("broken TLS: ")


def send_endlessly(to: socket.socket, data: bytes) -> NoReturn:
    while True:
        to.sendall(data)


def test_a_peer_that_does_not_read_is_cut_off(lab: Lab) -> None:
    with MockDevice(lab.server.address, tls=lab.paired("headset").context()) as device:
        device.start()
        control = device.wires["control"].socket
        with pytest.raises(OSError, match=r"EOF|reset|pipe|timed out"):
            send_endlessly(control, encode_frame(Kind.PING) * 1000)
    assert lab.sink.await_report().state is State.LOST
