"""The host: whatever a paired device sends, nothing breaks, and the next device is served."""

import struct
from collections.abc import Iterator

from bodies import CHANNELS, CONFIGURE, CONFIGURED, OPENINGS, REQUEST, SESSION, TICKET
from fake_sink import FakeGraph
from frame_bytes import json_bytes
from ml2_receiver.configuration.app_rules import AppRules, NameRules
from ml2_receiver.errors import ProtocolError
from ml2_receiver.session.actions import Send
from ml2_receiver.session.connection import Connection
from ml2_receiver.session.openings import LANE_KINDS, Openings
from ml2_receiver.wire.frame import Frame, FrameParser, encode_frame
from ml2_receiver.wire.kinds import OPENING, Kind, Side
from scene import Scene, hello
from vectors import vectors

# Followed by where it goes on: the last two are the end of a lane and time that passes.
_STATES = ("connected", "welcomed", "configuring", "streaming", "opened")
_LANES = ("stranger", "control", "time", "sensors", "world_left", "link_test", "ros", "bulk_1")
_ANY = NameRules(("/robot/**", "/headset/*", "/tf"))
_END, _TIME = len(_LANES), len(_LANES) + 1
_LENGTH = struct.Struct("<H")
_TICK_S = 0.3
_GIVE_UP_S = 10.0
_MOST_EVENT_CHARACTERS = 2000


def seeds() -> Iterator[bytes]:
    """A state, then steps: lane, length, and so many bytes there."""
    for case, data in vectors("malformed", "Receiver*"):
        is_open = case["lane"] == "control" and case["given"] != "connected"
        is_joined = case["given"] in ("streaming", "opened")
        lane = case["lane"] if is_open or is_joined else "stranger"
        rest = bytes([_END, _LANES.index(lane), _TIME])
        yield bytes([_STATES.index(case["given"])]) + _steps(lane, data) + rest
    for case, data in vectors("wire"):
        if case["sender"] == "device" and case["lane"] in _LANES:
            for state in (2, 3, 4):
                yield bytes([state]) + _steps(case["lane"], data)


def _steps(lane: str, data: bytes) -> bytes:
    most = (1 << 16) - 1
    pieces = [data[at : at + most] for at in range(0, len(data), most)]
    return b"".join(bytes([_LANES.index(lane)]) + _LENGTH.pack(len(it)) + it for it in pieces)


def read(data: bytes) -> None:
    replay = _Replay(data[0] % len(_STATES))
    at = 1
    while at < len(data):
        step, at = data[at] % (_TIME + 1), at + 1
        if step == _TIME:
            replay.scene.pass_time(_TICK_S)
        elif step == _END and at < len(data):
            replay.end(_LANES[data[at] % len(_LANES)])
            at += 1
        elif step < len(_LANES) and at + _LENGTH.size <= len(data):
            (count,) = _LENGTH.unpack_from(data, at)
            at += _LENGTH.size
            replay.feed(_LANES[step], data[at : at + count])
            at += count
    replay.check()


class _Replay:
    """A Host in a state of tests/conformance, whose lanes are fed bytes as Server would."""

    def __init__(self, state: int) -> None:
        self.graph = FakeGraph()
        self.scene = Scene(app=AppRules(_ANY, _ANY, _ANY, _ANY), graph=self.graph)
        self.scene.request(CONFIGURE["streams"])
        self._secrets: list[str] = []
        self._lanes: dict[str, tuple[Connection, FrameParser]] = {}
        if state >= _STATES.index("welcomed"):
            self.scene.begin(hello(ros=_STATES[state] == "opened"))
            welcome = self.scene.welcome
            self._secrets = [welcome.session, *welcome.tickets.values()]
            self._open("control", self.scene.control)
        joined = {"configuring": 1, "streaming": 4, "opened": 6}.get(_STATES[state], 0)
        for lane in _LANES[_LANES.index("time") :][:joined]:
            self._open(lane, self.scene.join(lane))
        if _STATES[state] in ("streaming", "opened"):
            self._start()
        if _STATES[state] == "opened":
            for body in OPENINGS:
                self.scene.receive(self.scene.control, Kind.OPEN, json_bytes(body))

    def _start(self) -> None:
        for channel in CHANNELS:
            self.scene.receive(self.scene.control, Kind.CHANNEL, json_bytes(channel))
        request = self.scene.asked()[-1].request
        configured = CONFIGURED | {"request": request}
        self.scene.receive(self.scene.control, Kind.CONFIGURED, json_bytes(configured))
        assert self.scene.kinds(self.scene.control)[-1] == Kind.START

    def _open(self, lane: str, connection: Connection) -> None:
        self._lanes[lane] = connection, FrameParser(Side.DEVICE)

    def feed(self, lane: str, data: bytes) -> None:
        if lane not in self._lanes:
            self._open(lane, self.scene.connect())
        connection, parser = self._lanes[lane]
        rest = memoryview(self._filled_in(data))
        while rest and not connection.is_closing:
            self._enter_lane(connection, parser)
            into = parser.get_buffer()
            count = min(len(into), len(rest))
            into[:count], rest = rest[:count], rest[count:]
            try:
                frame = parser.buffer_updated(count)
                if frame is not None:
                    self._dispatch(connection, frame)
            except ProtocolError as error:
                self.scene.fail(connection, error)
        if connection.is_closing:
            self.end(lane)

    @staticmethod
    def _enter_lane(connection: Connection, parser: FrameParser) -> None:
        lane = connection.lane or OPENING
        if parser.lane is not lane:
            parser.enter(lane, has_openings=connection.openings is not None)

    def _dispatch(self, connection: Connection, frame: Frame) -> None:
        if frame.header.kind == Kind.DATA:
            route = connection.routes.get(frame.header.channel)
            if route is None:
                raise self.scene.host.refusal(connection, frame.header.channel)
            route.receive(frame, 0, 0)
        elif frame.header.kind in LANE_KINDS and connection.openings is not None:
            self._pass_on(connection, connection.openings, frame)
        elif frame.header.kind != Kind.TIME_REQUEST:
            self.scene.receive_frame(connection, frame)

    def _pass_on(self, connection: Connection, openings: Openings, frame: Frame) -> None:
        """Checks that a frame without an error is passed on, counted or answered."""
        assert connection.lane is not None
        before = len(self.graph.received_numbers) + openings.late
        is_answered = openings.received(connection.lane.name, frame) is not None
        assert len(self.graph.received_numbers) + openings.late + is_answered == before + 1

    def _filled_in(self, data: bytes) -> bytes:
        """Returns the frames with this session's values in place of the placeholders."""
        if not self._secrets:
            return data
        tickets = self.scene.welcome.tickets
        ticket = next((it for lane, it in tickets.items() if lane.encode() in data), "")
        asked = self.scene.asked() if "control" in self._lanes else []
        request = str(asked[-1].request if asked else 0)
        values = {SESSION: self._secrets[0], TICKET: ticket, REQUEST: request}
        for text, value in values.items():
            data = data.replace(text.encode(), value.rjust(len(text)).encode())
        return data

    def end(self, lane: str) -> None:
        if lane in self._lanes:
            connection, parser = self._lanes.pop(lane)
            fault = None if parser.is_between_frames else "ended inside a frame"
            self.scene.end(connection, fault)

    def check(self) -> None:
        for event in self.scene.sink.events:
            assert event.isprintable(), event
            assert len(event) <= _MOST_EVENT_CHARACTERS
            assert not any(secret in event for secret in self._secrets), event
        for lane in list(self._lanes):
            self.end(lane)
        self.scene.pass_time(_GIVE_UP_S)
        self._check_all_is_over()
        control = self.scene.greet(hello("next"))
        assert self.scene.kinds(control) == [Kind.WELCOME]

    def _check_all_is_over(self) -> None:
        session = self.scene.host.session
        assert session is None or session.is_over
        sent = [it for it in self.scene.actions if isinstance(it, Send)]
        for it in sent:
            encode_frame(it.kind, it.body.to_bytes() if it.body else b"")
        assert len(self.scene.sink.reports) == [it.kind for it in sent].count(Kind.WELCOME)
