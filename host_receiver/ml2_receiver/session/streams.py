"""What a device was asked to run, what it answered and announced, and where its DATA goes."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from ..errors import ErrorCode, ProtocolError, PublishError
from ..table.stream_table import StreamTable, Topic
from ..wire.json_body import Scalar
from ..wire.messages import Channel, ChannelEnd, Configure, Configured, Start, StreamAnswer
from .connection import Route
from .sink import Publish, Sink
from .statistics import Instance, TopicStatistics

type Request = Mapping[str, Mapping[str, Scalar]]


@dataclass(frozen=True)
class Demand:
    """What a headset shall run: `request`, but not now the streams that are `idle`.

    While it is paused nothing starts, and what runs stops. It is never asked for the streams in
    `withheld`, which has the reasons.
    """

    request: Request
    is_paused: bool = False
    idle: Collection[str] = ()
    withheld: Mapping[str, str] = field(default_factory=dict)

    def asked(self) -> Request:
        """The request as the headset sees it."""
        return {id: it for id, it in self.request.items() if id not in self.withheld}

    def refusals(self) -> dict[str, StreamAnswer]:
        """The answers for what it is not asked for."""
        ids = self.request.keys() & self.withheld.keys()
        return {id: StreamAnswer("refused", None, self.withheld[id]) for id in sorted(ids)}


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
        self._table, self._instance, self._sink = table, instance, sink
        self._frame_prefix = frame_prefix or None
        self._topics = {
            topic.name: topic for stream in table.streams.values() for topic in stream.topics
        }
        self._announced = 0
        self._numbers: dict[str, int] = {}
        self._live: dict[int, Topic] = {}
        self._unrouted: dict[int, tuple[str, Route]] = {}
        self._request = 0
        self._requested: Request = {}
        self._requested_before: Request = {}
        self._negotiated: Request | None = None
        self._withheld: Mapping[str, StreamAnswer] = {}
        self._offered: list[Topic] = []
        self._is_answered = self._is_started = self._has_started = self._runs = False

    @property
    def topics(self) -> list[Topic]:
        """Those of all streams that were negotiated and not refused, running or not."""
        return [topic for topic in self._offered if self.answers[topic.stream].result != "refused"]

    @property
    def is_answered(self) -> bool:
        """Whether the device has answered all that it was asked."""
        return self._is_answered

    def is_running(self, stream: str) -> bool:
        """Whether the device is to run it at present."""
        return self._runs and stream in self._requested

    def ask_again(self) -> None:
        """All that is asked for is negotiated anew, since the device would accept more of it."""
        if self._is_answered:
            self._negotiated = None

    def topic(self, name: str) -> Topic:
        """The row of the stream table, or of a topic that the device has named."""
        return self._topics.get(name) or self._instance.custom[name]

    def due(self, demand: Demand) -> Configure | Start | None:
        """What to send next; None when nothing, or while an answer is outstanding.

        A request is negotiated as a whole before any of it starts, so that all its answers and
        topics are known; then what is not wanted at present is left out.
        """
        if self._request and not self._is_answered:
            return None
        asked, withheld = demand.asked(), demand.refusals()
        if (self._negotiated, self._withheld) != (asked, withheld):
            self._negotiated, self._withheld = asked, withheld
            return self._configure(asked)
        wanted = self._wanted(demand)
        if wanted != self._requested:
            return self._configure(wanted)
        is_idle = not wanted and self._negotiated
        return None if demand.is_paused or is_idle or self._is_started else self._start()

    def _wanted(self, demand: Demand) -> Request:
        if demand.is_paused:
            return {} if self._runs else self._requested
        return {id: values for id, values in demand.asked().items() if id not in demand.idle}

    def _configure(self, streams: Request) -> Configure:
        self._request += 1
        self._requested_before, self._requested = self._requested, streams
        self._runs = self._runs and bool(streams)
        self._is_answered = self._is_started = False
        return Configure(self._request, streams, self._frame_prefix)

    def _start(self) -> Start:
        """From now on the channels of the answered request have routes."""
        for channel, (lane, route) in self._unrouted.items():
            self.routes[lane][channel] = route
        self._unrouted.clear()
        self._is_started = self._has_started = self._runs = True
        is_open = self._table.custom_topics.stream in self._requested
        return Start(self._request, self._announced if is_open else None)

    def announce(self, channel: Channel) -> PublishError | None:
        """CHANNEL opens its topic, or the error says why its DATA goes nowhere."""
        if not self._request:
            raise ProtocolError(ErrorCode.UNEXPECTED, "CHANNEL before CONFIGURE")
        topic = self._checked(channel)
        if channel.id in self._live or topic in self._live.values():
            raise ProtocolError(
                ErrorCode.CHANNEL, f"channel {channel.id}, {topic.name}, is announced already"
            )
        number = self._numbers.setdefault(topic.name, channel.id)
        if number != channel.id:
            raise ProtocolError(
                ErrorCode.CHANNEL, f"{topic.name} is channel {number}, not {channel.id}"
            )
        statistics = self._instance.topics.setdefault(topic.name, TopicStatistics())
        publish, refusal = self._open(topic)
        self._live[channel.id] = topic
        self._unrouted[channel.id] = topic.lane, Route(publish, statistics)
        self._announced += 1
        self._is_started = False
        if self._is_answered and topic not in self._offered:
            self._offered.append(topic)
        return refusal

    def _open(self, topic: Topic) -> tuple[Publish, PublishError | None]:
        try:
            return self._sink.open(topic), None
        except PublishError as error:
            return _refuse, error

    def _checked(self, channel: Channel) -> Topic:
        if channel.stream == self._table.custom_topics.stream:
            return self._checked_custom(channel)
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

    def _checked_custom(self, channel: Channel) -> Topic:
        rules, known = self._table.custom_topics, self._instance.custom
        topic = rules.topic(channel.topic, channel.type)
        found = (channel.role, channel.qos, channel.lane)
        if topic is None or found != (rules.role, rules.qos, rules.lane):
            raise ProtocolError(
                ErrorCode.CHANNEL, f"no custom topic can be {channel.topic!r}: {channel!r}"
            )
        # Announced by itself, it may cross the CONFIGURE that no longer wants it.
        if rules.stream not in self._requested and (
            self._is_answered or rules.stream not in self._requested_before
        ):
            raise ProtocolError(ErrorCode.CHANNEL, f"{topic.name} was not asked for")
        if known.get(topic.name, topic) != topic:
            raise ProtocolError(
                ErrorCode.CHANNEL, f"{topic.name} is {known[topic.name].type}, not {topic.type}"
            )
        if topic.name not in known and len(known) >= rules.max_topics:
            raise ProtocolError(
                ErrorCode.CHANNEL, f"{topic.name} is one more than {rules.max_topics} custom topics"
            )
        return known.setdefault(topic.name, topic)

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
            self.answers, self._offered = {**configured.streams, **self._withheld}, live
        else:
            self.answers = {**self.answers, **configured.streams}
            self._offered += [topic for topic in live if topic not in self._offered]
        self._is_answered = True

    def refusal(self, channel: int) -> ProtocolError:
        """Why DATA of a channel without route is wrong."""
        if channel in self._unrouted or not self._has_started:
            return ProtocolError(ErrorCode.UNEXPECTED, f"DATA of channel {channel} before START")
        return ProtocolError(ErrorCode.CHANNEL, f"DATA of channel {channel}, unknown on this lane")


def _refuse(_: bytearray) -> None:
    raise PublishError("the topic could not be made")
