"""What a device was asked to run, what it answered and announced, and where its DATA goes."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from ..configuration.table import Scalar, StreamTable, Topic
from ..errors import ErrorCode, ProtocolError
from ..topics.sink import Sink
from ..wire.messages import Channel, ChannelEnd, Configure, Configured, Start, StreamAnswer
from .connection import Route
from .statistics import Instance, TopicStatistics

type Request = Mapping[str, Mapping[str, Scalar]]


@dataclass(frozen=True)
class Demand:
    """What a headset shall run: `request`, but not now the streams that are `idle`.

    While it is paused nothing starts, and what runs stops.
    """

    request: Request
    is_paused: bool = False
    idle: Collection[str] = ()


class Streams:
    """CONFIGURE, CHANNEL, CONFIGURED and START of one session.

    `routes` has each lane's routes by channel. They are read by the lanes' threads and filled
    here, by START.
    """

    def __init__(
        self, table: StreamTable, instance: Instance, sink: Sink, frame_prefix: str = ""
    ) -> None:
        self.answers: Mapping[str, StreamAnswer] = {}
        self.routes: dict[str, dict[int, Route]] = {"sensors": {}}
        self.routes |= {lane: {} for lane in table.image_lanes}
        self._instance, self._sink = instance, sink
        self._frame_prefix = frame_prefix or None
        self._topics = {
            topic.name: topic for stream in table.streams.values() for topic in stream.topics
        }
        self._live: dict[int, Topic] = {}
        self._unrouted: dict[int, tuple[str, Route]] = {}
        self._request = 0
        self._requested: Request = {}
        self._negotiated: Request | None = None
        self._offered: list[Topic] = []
        self._is_answered = self._is_started = self._has_started = self._runs = False

    @property
    def topics(self) -> list[Topic]:
        """Those of all streams that were negotiated and not refused, running or not."""
        return [topic for topic in self._offered if self.answers[topic.stream].result != "refused"]

    def is_running(self, stream: str) -> bool:
        """Whether the device is asked for it at present."""
        return stream in self._requested

    def topic(self, name: str) -> Topic:
        """The row of the stream table."""
        return self._topics[name]

    def due(self, demand: Demand) -> Configure | Start | None:
        """What to send next; None when nothing, or while an answer is outstanding.

        A request is negotiated as a whole before any of it starts, so that all its answers and
        topics are known; then what is not wanted at present is left out.
        """
        if self._request and not self._is_answered:
            return None
        if self._negotiated != demand.request:
            self._negotiated = demand.request
            return self._configure(demand.request)
        wanted = self._wanted(demand)
        if wanted != self._requested:
            return self._configure(wanted)
        is_idle = not wanted and demand.request
        return None if demand.is_paused or is_idle or self._is_started else self._start()

    def _wanted(self, demand: Demand) -> Request:
        if demand.is_paused:
            return {} if self._runs else self._requested
        return {id: values for id, values in demand.request.items() if id not in demand.idle}

    def _configure(self, streams: Request) -> Configure:
        self._request += 1
        self._requested = streams
        self._runs = self._runs and bool(streams)
        self._is_answered = self._is_started = False
        return Configure(self._request, streams, self._frame_prefix)

    def _start(self) -> Start:
        """From now on the channels of the answered request have routes."""
        for channel, (lane, route) in self._unrouted.items():
            self.routes[lane][channel] = route
        self._unrouted.clear()
        self._is_started = self._has_started = self._runs = True
        return Start(self._request)

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
        live = list(self._live.values())
        if self._requested == self._negotiated:
            self.answers, self._offered = configured.streams, live
        else:
            self.answers = {**self.answers, **configured.streams}
            self._offered += [topic for topic in live if topic not in self._offered]
        self._is_answered = True

    def refusal(self, channel: int) -> ProtocolError:
        """Why DATA of a channel without route is wrong."""
        if channel in self._unrouted or not self._has_started:
            return ProtocolError(ErrorCode.UNEXPECTED, f"DATA of channel {channel} before START")
        return ProtocolError(ErrorCode.CHANNEL, f"DATA of channel {channel}, unknown on this lane")
