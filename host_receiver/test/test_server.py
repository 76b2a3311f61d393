import os
import secrets
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest

from fake_sink import FakeSink
from ml2_receiver.errors import ListenError
from ml2_receiver.session.report import State
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import Limits, ReceiverSettings
from ml2_receiver.session.sink import Applied, Publish
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.transport.access import Everybody
from ml2_receiver.transport.listener import listen
from ml2_receiver.transport.transport import Transport
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, encode_frame
from ml2_receiver.wire.kinds import Kind
from mock_device import PAYLOAD, MockDevice, Wire
from scene import PATIENT, REQUEST
from waiting import LIMIT_S, await_true

IMAGE = "world_left/image_raw"
INFO = "world_left/camera_info"
CS6 = 0xC0  # RFC 2474


def serve(sink: FakeSink, limits: Limits = PATIENT, *, is_paused: bool = False) -> Server:
    server = Server(
        listen(("127.0.0.1", 0)),
        Everybody(),
        sink,
        REQUEST,
        ReceiverSettings("host", "test", limits=limits),
        is_paused=is_paused,
    )
    server.start()
    return server


@pytest.fixture
def sink() -> FakeSink:
    return FakeSink()


@pytest.fixture
def server(sink: FakeSink) -> Iterator[Server]:
    server = serve(sink)
    yield server
    server.stop()


def mark_of(client: socket.socket) -> int:
    """The type of service with which this process sends to a client that is in it, too."""
    for fd in filter(Path.is_socket, Path("/proc/self/fd").iterdir()):
        with suppress(OSError), socket.socket(fileno=os.dup(int(fd.name))) as other:
            if other.getpeername() == client.getsockname():
                return other.getsockopt(socket.IPPROTO_IP, socket.IP_TOS)
    raise AssertionError("nobody sends to it")


def test_what_is_urgent_is_marked_towards_the_headset_too(server: Server) -> None:
    with MockDevice(server.address) as device:
        device.start()
        marks = {lane: mark_of(wire.socket) for lane, wire in device.wires.items()}
    assert marks.pop("world_left") == 0
    assert marks == dict.fromkeys(("control", "time", "sensors"), CS6)


def payload(length: int) -> bytes:
    return CDR_ENCAPSULATION + secrets.token_bytes(length - 4)


def test_payloads_of_every_size_arrive_as_they_were_sent(server: Server, sink: FakeSink) -> None:
    sizes = [4, 1_032_336, 5, 1 << 20, (1 << 20) + 1, 16 << 20, 300_000, 299_999]
    sent = [payload(size) for size in sizes]
    with MockDevice(server.address) as device:
        device.start()
        for message in sent:
            device.publish(IMAGE, message)
        assert sink.await_payloads(IMAGE, len(sent)) == sent


def test_lanes_do_not_wait_for_each_other(server: Server, sink: FakeSink) -> None:
    with MockDevice(server.address) as device:
        device.start()
        image = encode_frame(Kind.DATA, payload(1 << 20), channel=device.number(IMAGE))
        device.wires["world_left"].socket.sendall(image[:-1])
        device.publish(INFO)
        sink.await_payloads(INFO, 1)
        assert IMAGE not in sink.payloads
        device.wires["world_left"].socket.sendall(image[-1:])
        sink.await_payloads(IMAGE, 1)


class Curious(FakeSink):
    """Asks the server for its report in each call, and notes when payloads arrive."""

    server: Server

    def __init__(self) -> None:
        super().__init__()
        self.published_ns: list[int] = []

    def open(self, topic: Topic) -> Publish:
        assert self.server.report() is not None
        publish = super().open(topic)

        def publish_and_note(payload: bytearray) -> None:
            self.published_ns.append(time.time_ns())
            publish(payload)

        return publish_and_note

    def configured(self, applied: Applied) -> None:
        assert self.server.report() is not None
        super().configured(applied)


def test_a_sink_may_ask_for_the_report_and_a_message_has_the_time_of_its_publication() -> None:
    sink = Curious()
    sink.server = serve(sink)
    with MockDevice(sink.server.address) as device:
        device.start()
        before_ns = time.time_ns()
        device.publish(IMAGE)
        sink.await_payloads(IMAGE, 1)
    sink.server.stop()
    (row,) = [it for it in sink.await_report().topics if it.topic.name == IMAGE]
    ((_, _, received_ns, published_ns),) = row.statistics.times_ns(0, 1).tolist()
    assert before_ns <= received_ns <= published_ns <= sink.published_ns[0]


class Failing(Everybody):
    """Fails as nobody expects, until it is mended."""

    is_mended = False

    def refresh(self) -> bool:
        if not self.is_mended:
            raise RuntimeError("no such keys")
        return super().refresh()

    def transport(self, accepted: socket.socket) -> Transport:
        if not self.is_mended:
            raise RuntimeError("no such transport")
        return super().transport(accepted)


class Mute(FakeSink):
    """Fails, too."""

    is_mended = False

    def event(self, text: str) -> None:
        if not self.is_mended:
            raise RuntimeError(f"nobody hears {text}")
        super().event(text)


@pytest.mark.parametrize("kind", [FakeSink, Mute])
def test_what_nobody_expects_ends_neither_accepting_nor_the_timer(
    kind: type[FakeSink], capfd: pytest.CaptureFixture[str]
) -> None:
    sink, access = kind(), Failing()
    settings = ReceiverSettings("host", "test", limits=PATIENT)
    server = Server(listen(("127.0.0.1", 0)), access, sink, REQUEST, settings)
    server.start()
    host, _, port = server.address.rpartition(":")
    try:
        with socket.create_connection((host, int(port)), LIMIT_S) as refused:
            assert refused.recv(1) == b"", "it is closed"
        access.is_mended = True
        if isinstance(sink, Mute):
            sink.is_mended = True
        with MockDevice(server.address) as device:
            device.start()
            device.publish(IMAGE)
            sink.await_payloads(IMAGE, 1)
    finally:
        server.stop()
    told = "".join(sink.events) + capfd.readouterr().err
    assert "internal error, please report it: RuntimeError('no such keys')" in told


def test_time_is_answered_at_once(server: Server) -> None:
    with MockDevice(server.address) as device:
        device.connect()
        device.join("time")
        before_ns = time.time_ns()
        t1, t2, t3 = device.exchange_time(-7)
        assert t1 == -7
        assert before_ns <= t2 <= t3 <= time.time_ns()


def test_an_orderly_end_loses_nothing(server: Server, sink: FakeSink) -> None:
    with MockDevice(server.address) as device:
        device.start()
        for _ in range(200):
            device.publish(IMAGE, PAYLOAD + bytes(10_000))
            device.publish(INFO)
        device.leave()
    report = sink.await_report()
    assert (report.state, report.is_final) == (State.ENDED, True)
    counts = {row.topic.name: row.statistics.received for row in report.topics}
    assert (counts[IMAGE], counts[INFO]) == (200, 200)


def test_a_device_takes_the_place_of_its_own_dead_session_and_is_told_what_arrived(
    server: Server, sink: FakeSink
) -> None:
    with MockDevice(server.address) as dead, MockDevice(server.address) as back:
        dead.start()
        for _ in range(3):
            dead.publish(IMAGE)
        sink.await_payloads(IMAGE, 3)
        back.start()
        assert back.welcome.received is not None
        assert back.welcome.received[IMAGE] == 3
        for wire in dead.wires.values():
            wire.expect_end()
        back.device = dead.device
        back.publish(IMAGE, skip=2)
        sink.await_payloads(IMAGE, 4)
        report = server.report()
    assert report is not None
    (statistics,) = [row.statistics for row in report.topics if row.topic.name == IMAGE]
    assert (statistics.received, statistics.gaps, statistics.produced) == (4, 2, 6)


def test_what_the_link_carries_is_measured_beside_the_streams(
    server: Server, sink: FakeSink
) -> None:
    with MockDevice(server.address) as device:
        device.start()
        server.test_link()
        assert device.expect_link_test().bytes == 64 << 20
        for _ in range(100):
            device.fill(1 << 16)
            device.publish(IMAGE, PAYLOAD + bytes(10_000))
        sink.await_payloads(IMAGE, 100)
        device.fill(0)
        device.leave()
    report = sink.await_report()
    assert report.link_test is not None
    assert (report.link_test.state, report.link_test.filler_bytes) == ("measured", 100 << 16)
    assert report.link_test.free_mbit_per_s > report.link_test.streams_mbit_per_s > 0
    counts = {row.topic.name: row.statistics for row in report.topics}
    assert (counts[IMAGE].received, counts[IMAGE].gaps) == (100, 0)
    assert (report.state, report.is_final, report.skipped_frames) == (State.ENDED, True, 0)


def test_a_peer_that_goes_on_writing_after_its_error_is_not_reset(sink: FakeSink) -> None:
    server = serve(sink, replace(PATIENT, linger_s=LIMIT_S))
    with MockDevice(server.address) as device:
        device.start()
        lane = device.wires["world_left"]
        lane.socket.sendall(b" " * 100_000)
        lane.expect_error("malformed")
        deadline_s = time.monotonic() + 0.5
        while time.monotonic() < deadline_s:
            lane.socket.sendall(b" " * 100_000)
    sink.await_event("expected magic 0x324d, found 0x2020")
    server.stop()


def test_tls_without_tls_here_is_named(server: Server, sink: FakeSink) -> None:
    wire = Wire(server.address, "control")
    wire.socket.sendall(b"\x16\x03\x01" + bytes(500))
    assert "found TLS: only this side has --insecure" in wire.expect_error("malformed").message
    wire.socket.close()


def test_a_paused_server_starts_when_told(sink: FakeSink) -> None:
    server = serve(sink, is_paused=True)
    with MockDevice(server.address) as device:
        device.configure()
        sink.await_event("streams: ")
        report = server.report()
        assert report is not None
        assert not any(row.is_running for row in report.topics)
        server.begin()
        device.wires["control"].expect(Kind.START)
    server.stop()


def test_seventeen_silent_peers_do_not_keep_a_headset_out(server: Server) -> None:
    silent = [Wire(server.address, "control") for _ in range(17)]
    silent[0].expect_end()
    with MockDevice(server.address) as device:
        device.connect()
    for wire in silent:
        wire.socket.close()


def test_a_stopped_server_says_goodbye_and_leaves_no_threads(sink: FakeSink) -> None:
    before = set(threading.enumerate())
    server = serve(sink, replace(PATIENT, linger_s=60))
    with MockDevice(server.address) as device:
        device.start()
        pending = Wire(server.address, "control")
        server.stop()
        await_true(lambda: set(threading.enumerate()) <= before)
        device.wires["control"].expect(Kind.BYE)
        for wire in (*device.wires.values(), pending):
            wire.expect_end()
        pending.socket.close()
    assert sink.await_report().state is State.ENDED


def test_a_port_in_use_is_named_with_its_process_and_what_to_do() -> None:
    with listen(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(ListenError) as raised:
            listen(("127.0.0.1", port))
    said = str(raised.value)
    assert said.startswith(f"cannot listen on 127.0.0.1:{port}: the port is used by ")
    assert said.endswith(f"(pid {os.getpid()})")
    assert raised.value.hint == "Stop it, or choose another port with --listen."


def test_an_unknown_host_is_named() -> None:
    with pytest.raises(ListenError, match=r"cannot listen on nowhere\.invalid:1: "):
        listen(("nowhere.invalid", 1))
