"""What a device was asked to run, what it answered and announced, and where its DATA goes."""

from collections.abc import Mapping

from .connection import Route
from .errors import ErrorCode, ProtocolError
from .messages import Channel, ChannelEnd, Configure, Configured, Start, StreamAnswer
from .sink import Sink
from .statistics import Instance, TopicStatistics
from .table import Scalar, StreamTable, Topic

type Request = Mapping[str, Mapping[str, Scalar]]


class Streams:
    """CONFIGURE, CHANNEL, CONFIGURED and START of one session.

    `routes` has each lane's routes by channel. They are read by the lanes' threads and filled
    here, by START.
    """

    def __init__(self, table: StreamTable, instance: Instance, sink: Sink) -> None:
        self.answers: Mapping[str, StreamAnswer] = {}
        self.routes: dict[str, dict[int, Route]] = {"sensors": {}}
        self.routes |= {lane: {} for lane in table.image_lanes}
        self._instance, self._sink = instance, sink
        self._topics = {
            topic.name: topic for stream in table.streams.values() for topic in stream.topics
        }
        self._live: dict[int, Topic] = {}
        self._unrouted: dict[int, tuple[str, Route]] = {}
        self._request = 0
        self._requested: Request = {}
        self._is_answered = self._is_started = self._has_started = False

    @property
    def topics(self) -> list[Topic]:
        """The announced topics."""
        return list(self._live.values())

    def topic(self, name: str) -> Topic:
        """The row of the stream table."""
        return self._topics[name]

    @property
    def awaits_start(self) -> bool:
        """Whether the last CONFIGURE is answered and start() is due."""
        return self._is_answered and not self._is_started

    def configure(self, streams: Request) -> Configure:
        """The next CONFIGURE, asking for exactly these streams."""
        self._request += 1
        self._requested = streams
        self._is_answered = self._is_started = False
        return Configure(self._request, streams)

    def announce(self, channel: Channel) -> None:
        """CHANNEL opens its topic."""
        if not self._request:
            raise ProtocolError(ErrorCode.UNEXPECTED, "CHANNEL before CONFIGURE")
        topic = self._checked(channel)
        if channel.id in self._live or topic in self._live.values():
            raise ProtocolError(
                ErrorCode.CHANNEL, f"channel {channel.id}, {topic.name}, is announced already"
            )
        statistics = self._instance.topics.setdefault(topic.name, TopicStatistics())
        self._live[channel.id] = topic
        self._unrouted[channel.id] = topic.lane, Route(self._sink.open(topic), statistics)

    def _checked(self, channel: Channel) -> Topic:
        topic = self._topics.get(channel.topic)
        found = (channel.stream, channel.role, channel.type, channel.qos, channel.lane)
        if topic is None or found != (topic.stream, topic.role, topic.type, topic.qos, topic.lane):
            raise ProtocolError(
                ErrorCode.CHANNEL, f"the stream table has no {channel.topic!r} with {found!r}"
            )
        values = self._requested.get(topic.stream)
        if values is None or (topic.when is not None and not topic.when.holds(values)):
            raise ProtocolError(ErrorCode.CHANNEL, f"{topic.name} was not asked for")
        return topic

    def end(self, end: ChannelEnd) -> None:
        """CHANNEL_END; the route stays for what is under way."""
        if self._live.pop(end.id, None) is None:
            raise ProtocolError(ErrorCode.CHANNEL, f"channel {end.id} is not announced")

    def answer(self, configured: Configured) -> None:
        """CONFIGURED completes the announcements of a request."""
        if configured.request != self._request or self._is_answered:
            raise ProtocolError(ErrorCode.UNEXPECTED, f"CONFIGURED of request {configured.request}")
        if configured.streams.keys() != self._requested.keys():
            wrong = sorted(configured.streams.keys() ^ self._requested.keys())
            raise ProtocolError(
                ErrorCode.MALFORMED, f"CONFIGURED has to answer what was asked: {wrong!r}"
            )
        for topic in self._live.values():
            answer = configured.streams.get(topic.stream)
            if answer is None or answer.result == "refused":
                raise ProtocolError(
                    ErrorCode.CHANNEL, f"{topic.name} is announced, but {topic.stream} does not run"
                )
        self.answers = configured.streams
        self._is_answered = True

    def start(self) -> Start:
        """START of the answered request: from now on its channels have routes."""
        for channel, (lane, route) in self._unrouted.items():
            self.routes[lane][channel] = route
        self._unrouted.clear()
        self._is_started = self._has_started = True
        return Start(self._request)

    def refusal(self, channel: int) -> ProtocolError:
        """Why DATA of a channel without route is wrong."""
        if channel in self._unrouted or not self._has_started:
            return ProtocolError(ErrorCode.UNEXPECTED, f"DATA of channel {channel} before START")
        return ProtocolError(ErrorCode.CHANNEL, f"DATA of channel {channel}, unknown on this lane")
