"""A scripted device: does what the protocol asks of one, or what a test wants instead."""

import socket
import ssl
import struct
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from math import inf
from typing import Self

from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, Frame, FrameParser, Header
from ml2_receiver.wire.frame import encode_frame as encode
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.kinds import Kind, Side
from ml2_receiver.wire.messages import (
    Bye,
    Capabilities,
    Channel,
    ClockStatus,
    Configure,
    Error,
    Hello,
    Joined,
    LinkTest,
    Start,
    StreamAnswer,
    StreamStatus,
    Welcome,
)
from ml2_receiver.wire.opening_bodies import Open, Opened, SubscriptionStatus
from ml2_tools.playback.device import KINDS, Device, Reply
from waiting import LIMIT_S

PAYLOAD = CDR_ENCAPSULATION + bytes(4)
_PING_S = 0.5
_TIMES = struct.Struct("<qqq")


class Wire:
    """One connection of the device; `lane` is what it is or shall become.

    Args:
        tls: None is plaintext. With TLS only one thread at a time may use the connection.
        source: the address it comes from.
    """

    def __init__(
        self,
        address: str,
        lane: str,
        tls: ssl.SSLContext | None = None,
        source: str = "127.0.0.1",
    ) -> None:
        host, _, port = address.rpartition(":")
        own = None if ":" in host else (source, 0)
        self.socket = socket.create_connection((host.strip("[]"), int(port)), LIMIT_S, own)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if tls is not None:
            self.socket = tls.wrap_socket(self.socket)
        lane_of_table = load_table().lane(lane)
        self._parser = FrameParser(Side.RECEIVER, lane_of_table, has_openings=True)
        self._writing = threading.Lock()

    def send(self, kind: Kind, body: JsonBody | bytes = b"", **header: int) -> None:
        data = body if isinstance(body, bytes) else body.to_bytes()
        with self._writing:
            self.socket.sendall(encode(kind, data, **header))

    def receive(self, deadline_s: float = inf) -> Frame | None:
        """The next frame but PING and PONG, or None at the end of the connection.

        It fails after the deadline, of monotonic time.
        """
        while count := self.socket.recv_into(self._parser.get_buffer()):
            frame = self._parser.buffer_updated(count)
            if frame is not None and frame.header.kind not in (Kind.PING, Kind.PONG):
                return frame
            assert time.monotonic() < deadline_s, "nothing but PING and PONG comes"
        return None

    def expect(self, kind: Kind) -> bytearray:
        frame = self.receive()
        assert frame is not None, f"expected {kind.name}, found the end"
        assert frame.header.kind == kind, (kind, frame)
        return frame.body

    def expect_error(self, code: str) -> Error:
        """ERROR with this code, and then the end."""
        error = Error.parse(self.expect(Kind.ERROR))
        assert (error.code, error.fatal) == (code, True)
        assert self.receive() is None
        return error

    def expect_end(self) -> None:
        """The end, whatever is said before; a reset is one."""
        with suppress(ConnectionError):
            while self.receive() is not None:
                pass


class MockDevice:
    """One run of an app; as a context manager it closes all connections.

    It says PING only where a test is to take longer than a receiver waits for silent devices.
    """

    def __init__(
        self,
        address: str,
        device_id: str = "device",
        instance_id: str = "instance",
        *,
        says_ping: bool = False,
        has_ros: bool | None = None,
        tls: ssl.SSLContext | None = None,
    ) -> None:
        self.address = address
        self.tls = tls
        self.wires: dict[str, Wire] = {}
        self._welcomed: Wire | None = None
        self._gone = threading.Event()
        self._pinger = threading.Thread(target=self._ping) if says_ping else None
        names = (device_id, instance_id, f"{device_id} name", "mock")
        self.device = Device(Hello([1], *names, Capabilities([], has_ros), {}))

    @property
    def welcome(self) -> Welcome:
        return self.device.welcome

    def number(self, topic: str) -> int:
        """The channel of a topic."""
        return next(it for row, it in self.device.channels.items() if row.name == topic)

    def __enter__(self) -> Self:
        if self._pinger is not None:
            self._pinger.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._gone.set()
        if self._pinger is not None:
            self._pinger.join()
        self.disconnect()

    def _ping(self) -> None:
        while not self._gone.wait(_PING_S):
            control = self._welcomed
            with suppress(OSError):  # it may just be closed
                if control is not None:
                    control.send(Kind.PING)

    def disconnect(self) -> None:
        self._welcomed = None
        for wire in self.wires.values():
            wire.socket.close()
        self.wires.clear()

    def wire(self, lane: str) -> Wire:
        self.wires[lane] = Wire(self.address, lane, self.tls)
        return self.wires[lane]

    def greet(self) -> Wire:
        """HELLO, to be answered."""
        control = self.wire("control")
        control.send(Kind.HELLO, self.device.hello)
        return control

    def connect(self) -> Welcome:
        control = self.greet()
        self.device.begin(Welcome.parse(control.expect(Kind.WELCOME)))
        self._welcomed = control
        return self.welcome

    def ask_for(self, lane: str, **changes: str) -> Wire:
        """JOIN, to be answered."""
        wire = self.wire(lane)
        wire.send(Kind.JOIN, replace(self.device.join(lane), **changes))
        return wire

    def join(self, lane: str) -> Wire:
        wire = self.ask_for(lane)
        assert Joined.parse(wire.expect(Kind.JOINED)).lane == lane
        return wire

    def reach_configure(self) -> Configure:
        """Everything up to CONFIGURE."""
        self.connect()
        self.join("time")
        self.join("sensors")
        return Configure.parse(self.wires["control"].expect(Kind.CONFIGURE))

    def configure(self, refused: dict[str, str] | None = None) -> int:
        """Everything up to CONFIGURED; `refused` has the reasons by stream."""
        return self.answer(self.reach_configure(), refused)

    def reconfigure(self, refused: dict[str, str] | None = None) -> Configure:
        """The next CONFIGURE, answered; the receiver may say START to the one before."""
        frame = self.wires["control"].receive()
        if frame is not None and frame.header.kind == Kind.START:
            frame = self.wires["control"].receive()
        assert frame is not None
        assert frame.header.kind == Kind.CONFIGURE, frame
        asked = Configure.parse(frame.body)
        self.answer(asked, refused)
        return asked

    def answer(self, asked: Configure, refused: dict[str, str] | None = None) -> int:
        """CHANNELs and CONFIGURED; `refused` has the reasons by stream."""
        refused = refused or {}
        wanted = {
            topic.name: topic
            for stream, values in asked.streams.items()
            if stream not in refused
            for topic in load_table().streams[stream].topics
            if topic.when is None or topic.when.holds(values)
        }
        answers = {
            stream: StreamAnswer("refused", None, refused[stream])
            if stream in refused
            else StreamAnswer("applied", values)
            for stream, values in asked.streams.items()
        }
        for reply in self.device.configure(asked, list(wanted.values()), answers):
            self._reply(reply)
        return asked.request

    def _reply(self, reply: Reply) -> None:
        if isinstance(reply, Channel) and reply.lane not in self.wires:
            self.join(reply.lane)
        self.wires["control"].send(KINDS[type(reply)], reply)

    def expect_start(self, request: int) -> None:
        assert Start.parse(self.wires["control"].expect(Kind.START)).request == request

    def announce(self, topic: Topic) -> None:
        self._reply(self.device.announce(topic))

    def start(self, refused: dict[str, str] | None = None) -> None:
        """Everything up to START."""
        self.expect_start(self.configure(refused))

    def publish(
        self,
        topic: str,
        payload: bytes = PAYLOAD,
        skip: int = 0,
        capture_ns: int | None = None,
        send_ns: int = 0,
    ) -> None:
        """One DATA frame, captured now unless said otherwise, after `skip` dropped messages."""
        row = next(row for row in self.device.channels if row.name == topic)
        captured_ns = time.time_ns() if capture_ns is None else capture_ns
        header = self.device.data_header(row, captured_ns, send_ns, skip)
        self.wires[row.lane.name].send(Kind.DATA, payload, **header)

    def status(
        self,
        *,
        is_final: bool = False,
        streams: Mapping[str, StreamStatus] | None = None,
        openings: Mapping[str, SubscriptionStatus] | None = None,
    ) -> None:
        clock = ClockStatus("synchronised", -5, 6, 7)
        status = self.device.status(1.5, clock, is_final=is_final)
        self.wires["control"].send(Kind.STATUS, replace(status, streams=streams, openings=openings))

    def exchange_time(self, t1: int) -> tuple[int, int, int]:
        self.wires["time"].send(Kind.TIME_REQUEST, struct.pack("<q", t1))
        times: tuple[int, int, int] = _TIMES.unpack(self.wires["time"].expect(Kind.TIME_REPLY))
        return times

    def expect_link_test(self) -> LinkTest:
        """LINK_TEST, to be answered by fill()."""
        asked = LinkTest.parse(self.wires["control"].expect(Kind.LINK_TEST))
        if "link_test" not in self.wires:
            self.join("link_test")
        return asked

    def fill(self, length: int) -> None:
        """One FILLER frame; without length the end."""
        self.wires["link_test"].send(Kind.FILLER, bytes(length))

    def open(self, wanted: Open) -> Opened:
        """OPEN, answered; joins the lane `ros` for the first one."""
        if "ros" not in self.wires:
            self.join("ros")
        self.wires["control"].send(Kind.OPEN, wanted)
        return Opened.parse(self.await_control(Kind.OPENED))

    def await_control(self, kind: Kind) -> bytearray:
        """The next frame of this kind on control; others are passed over."""
        deadline_s = time.monotonic() + LIMIT_S
        while (frame := self.wires["control"].receive(deadline_s)) is not None:
            if frame.header.kind == kind:
                return frame.body
        raise AssertionError(f"expected {kind.name}, found the end")

    def message(self, lane: str = "ros") -> tuple[Header, bytes]:
        """The next MESSAGE on a lane."""
        frame = self.wires[lane].receive()
        assert frame is not None
        assert frame.header.kind == Kind.MESSAGE, frame
        return frame.header, bytes(frame.body)

    def leave(self) -> None:
        """The orderly end."""
        for lane, wire in self.wires.items():
            if lane != "control":
                wire.socket.close()
        self.status(is_final=True)
        self.wires["control"].send(Kind.BYE, Bye("done"))
        self.wires["control"].expect_end()
