"""A Host without sockets and threads; a test says what happens, and at what time."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from fake_sink import FakeSink
from ml2_receiver.configuration.app_rules import AppRules
from ml2_receiver.errors import ProtocolError, PublishError
from ml2_receiver.session.actions import Close, Ending, EndWill, Log, Open, Send, SessionEnded
from ml2_receiver.session.connection import Connection
from ml2_receiver.session.event_limit import event_limits
from ml2_receiver.session.graph import Graph
from ml2_receiver.session.host import Host
from ml2_receiver.session.report import Report
from ml2_receiver.session.settings import Limits, ReceiverSettings
from ml2_receiver.session.sink import Applied
from ml2_receiver.session.streams import DesiredStreams, Request
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.frame import MAGIC, VERSION, Frame, Header
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import (
    Capabilities,
    Channel,
    ChannelEnd,
    Configure,
    Configured,
    Error,
    Hello,
    Join,
    Link,
    Start,
    StreamAnswer,
    Welcome,
)

# So long, not 3 s, a machine may stand still in a test of sockets.
PATIENT = Limits(handshake_s=20.0, dead_s=20.0)
REQUEST: Request = {
    "world_left": {
        "stream": 0,
        "resolution_width": 1016,
        "resolution_height": 1016,
        "update_rate": 30,
        "format": "Grayscale",
    },
    "battery": {},
    "tf": {"layout": "flat"},
}
APPLIED = {stream: StreamAnswer("applied", values) for stream, values in REQUEST.items()}
TOPICS = [
    topic
    for stream, values in REQUEST.items()
    for topic in load_table().streams[stream].topics
    if topic.when is None or topic.when.holds(values)
]
IMAGE = TOPICS[0]


def hello(
    device_id: str = "a",
    instance_id: str = "1",
    versions: tuple[int, ...] = (1,),
    *,
    ros: bool | None = None,
) -> Hello:
    names = (device_id, instance_id, f"{device_id} name", "test")
    return Hello(list(versions), *names, Capabilities([], ros), {})


def channel(topic: Topic, number: int) -> Channel:
    fields = (topic.stream, topic.role, topic.name, topic.type, topic.qos, "frame", topic.lane.name)
    return Channel(number, *fields)


def data(channel: int, sequence: int = 0) -> Frame:
    payload = bytearray(b"\0\1\0\0....")
    return Frame(Header(MAGIC, VERSION, Kind.DATA, 0, channel, sequence, 8, 0, 0), payload)


def frame(kind: int, body: JsonBody | bytes = b"") -> Frame:
    payload = bytearray(body if isinstance(body, bytes) else body.to_bytes())
    return Frame(Header(MAGIC, VERSION, kind, 0, 0, 0, len(payload), 0, 0), payload)


class Scene:
    """Does at once what the host wants of the sink, and collects what it wants of connections.

    A test looks at that with sent() and ending().
    """

    def __init__(
        self,
        *,
        is_paused: bool = False,
        excluded: Mapping[str, str] = MappingProxyType({}),
        link: Link | None = None,
        app: AppRules | None = None,
        graph: Graph | None = None,
    ) -> None:
        self.now_s = 100.0
        self.sink = FakeSink()
        self.actions: list[Send | Close] = []
        self.desired = DesiredStreams(REQUEST, is_paused, (), excluded, link)
        settings = ReceiverSettings("host", "test", excluded=excluded)
        self.app = app or AppRules()
        self._ros = True if graph else None
        self.host = Host(replace(settings, app=lambda: self.app, graph=graph))
        self._limits = event_limits(self.sink.event, lambda: self.now_s)
        self.welcome: Welcome
        self.control: Connection
        self.lanes: dict[str, Connection] = {}

    def perform(self) -> None:
        while self.host.actions:
            match self.host.actions.popleft():
                case Send() | Close() as action:
                    self.actions.append(action)
                case Open(topic=topic, route=route) as action:
                    try:
                        route.publish = self.sink.open(topic)
                    except PublishError as refusal:
                        self.host.topic_refused(action, str(refusal), self.now_s)
                case EndWill(will):
                    will.close()
                case Applied() as applied:
                    self.sink.configured(applied)
                case SessionEnded(report):
                    self.sink.session_ended(report)
                case Log(text, cause):
                    self._limits[cause].say(text)

    def desire(self, **changes: Any) -> None:
        """Changes fields of DesiredStreams."""
        self.desired = replace(self.desired, **changes)
        self.host.update(self.desired, self.now_s)
        self.perform()

    def request(self, request: Request, link: Link | None = None) -> None:
        self.desire(request=request, link=link)

    def test_link(self) -> None:
        self.host.test_link(self.now_s)
        self.perform()

    def report(self) -> Report:
        assert self.host.session is not None
        return self.host.session.report(self.now_s)

    def connect(self, host: str = "address") -> Connection:
        connection = Connection(host, 1, self.now_s)
        self.host.opened(connection)
        self.perform()
        return connection

    def receive(self, connection: Connection, kind: int, body: JsonBody | bytes = b"") -> None:
        self.receive_frame(connection, frame(kind, body))

    def receive_frame(self, connection: Connection, received: Frame) -> None:
        self.host.received(connection, received, self.now_s)
        self.host.update(self.desired, self.now_s)
        self.perform()

    def fail(self, connection: Connection, error: ProtocolError) -> None:
        self.host.failed(connection, error)
        self.perform()

    def pass_time(self, seconds: float) -> None:
        """Ticks as often as a server does."""
        begin_s = self.now_s
        for tick in range(1, int(seconds / 0.1)):
            self.stand_still(begin_s + tick * 0.1 - self.now_s)
        self.stand_still(begin_s + seconds - self.now_s)

    def stand_still(self, seconds: float) -> None:
        """Ticks only after this time."""
        self.now_s += seconds
        self.host.tick(self.now_s)
        self.perform()

    def sent(self, connection: Connection) -> list[tuple[Kind, JsonBody | None]]:
        """Everything this connection was sent."""
        sends = [action for action in self.actions if isinstance(action, Send)]
        return [(send.kind, send.body) for send in sends if send.connection is connection]

    def kinds(self, connection: Connection) -> list[Kind]:
        return [kind for kind, _ in self.sent(connection)]

    def ending(self, connection: Connection) -> Ending | None:
        endings = [
            action.ending
            for action in self.actions
            if isinstance(action, Close) and action.connection is connection
        ]
        assert len(endings) <= 1
        return endings[0] if endings else None

    def error(self, connection: Connection) -> str | None:
        """The code of the fatal ERROR that ended a connection."""
        kind, body = self.sent(connection)[-1] if self.sent(connection) else (None, None)
        if kind != Kind.ERROR:
            return None
        assert isinstance(body, Error)
        assert body.fatal
        assert self.ending(connection) is Ending.DISCARD
        return body.code

    # A session, step by step

    def greet(self, greeting: Hello | None = None) -> Connection:
        connection = self.connect()
        self.receive(connection, Kind.HELLO, greeting or hello(ros=self._ros))
        return connection

    def begin(self, greeting: Hello | None = None) -> None:
        """Up to WELCOME."""
        self.control = self.greet(greeting)
        self.take_welcome()

    def take_welcome(self) -> None:
        kind, body = self.sent(self.control)[-1]
        assert kind == Kind.WELCOME
        assert isinstance(body, Welcome)
        self.welcome = body
        self.lanes = {}

    def join(self, lane: str, session: str | None = None, ticket: str | None = None) -> Connection:
        connection = self.connect()
        own = self.welcome.tickets.get(lane, "")
        join = Join(session or self.welcome.session, ticket or own, lane)
        self.receive(connection, Kind.JOIN, join)
        self.lanes[lane] = connection
        return connection

    def configure(self) -> int:
        """Up to CONFIGURE; returns its request."""
        self.begin()
        self.join("time")
        self.join("sensors")
        kind, body = self.sent(self.control)[-1]
        assert kind == Kind.CONFIGURE
        assert isinstance(body, Configure)
        return body.request

    def announce(self, topic: Topic, number: int) -> None:
        self.receive(self.control, Kind.CHANNEL, channel(topic, number))

    def answer(self) -> int:
        """Up to CONFIGURED; channels have the numbers of their place in TOPICS, from 1."""
        request = self.configure()
        self.join("world_left")
        for number, topic in enumerate(TOPICS, 1):
            self.announce(topic, number)
        self.receive(self.control, Kind.CONFIGURED, Configured(request, APPLIED))
        return request

    def asked(self) -> list[Configure]:
        """All that the device was asked for."""
        return [body for _, body in self.sent(self.control) if isinstance(body, Configure)]

    def comply(self, refused: Mapping[str, StreamAnswer] = MappingProxyType({})) -> None:
        """Answers the last CONFIGURE after start() as a device does."""
        asked = self.asked()[-1]
        session = self.host.session
        assert session is not None
        live = set(session.streams._live.values())
        wanted = {
            topic
            for stream in asked.streams.keys() - refused.keys()
            for topic in load_table().streams[stream].topics
            if topic.when is None or topic.when.holds(asked.streams[stream])
        }
        for topic in live - wanted:
            self.receive(self.control, Kind.CHANNEL_END, ChannelEnd(self._number(topic)))
        for topic in wanted - live:
            self.announce(topic, self._number(topic))
        answers = {id: StreamAnswer("applied", values) for id, values in asked.streams.items()}
        configured = Configured(asked.request, answers | dict(refused))
        self.receive(self.control, Kind.CONFIGURED, configured)

    @staticmethod
    def _number(topic: Topic) -> int:
        rest = [t for s in load_table().streams.values() for t in s.topics if t not in TOPICS]
        return 1 + [*TOPICS, *rest].index(topic)

    def start(self) -> None:
        """Up to START."""
        request = self.answer()
        assert self.sent(self.control)[-1] == (Kind.START, Start(request))

    def receive_data(self, lane: str, number: int, sequence: int = 0) -> None:
        self.lanes[lane].routes[number].receive(data(number, sequence), 0, 0)

    def end(self, connection: Connection, fault: str | None = None) -> None:
        self.host.closed(connection, fault, self.now_s)
        self.perform()

    def is_connected(self) -> bool:
        session = self.host.session
        return session is not None and session.state.value == "connected"


def started(**options: Any) -> Scene:
    """A Scene up to START; the options are the Scene's."""
    scene = Scene(**options)
    scene.start()
    return scene
