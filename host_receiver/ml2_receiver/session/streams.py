"""The negotiation of one session: which streams run, and which channel carries which topic."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto

from ..errors import ErrorCode, ProtocolError
from ..table.stream_table import StreamTable, Topic
from ..wire.json_body import Scalar
from ..wire.messages import (
    Channel,
    ChannelEnd,
    Configure,
    Configured,
    Link,
    Start,
    Status,
    StreamAnswer,
    StreamStatus,
)
from .connection import Route
from .stream_state import stream_states

type Request = Mapping[str, Mapping[str, Scalar]]


@dataclass(frozen=True)
class DesiredStreams:
    """The streams that the headset shall run.

    Attributes:
        request: the values of each stream that the user enabled.
        is_paused: True stops all streams and starts none.
        idle: streams that are not needed at present.
        excluded: streams that the headset is never asked for, with the reasons.
        link: how images give way to the link; None means that they do not.
    """

    request: Request
    is_paused: bool = False
    idle: Collection[str] = ()
    excluded: Mapping[str, str] = field(default_factory=dict)
    link: Link | None = None

    def requested(self) -> Request:
        """Returns the request as the headset sees it."""
        return {id: it for id, it in self.request.items() if id not in self.excluded}

    def refusals(self) -> dict[str, StreamAnswer]:
        """Returns the answers for the streams that the headset is not asked for."""
        ids = self.request.keys() & self.excluded.keys()
        return {id: StreamAnswer("refused", None, self.excluded[id]) for id in sorted(ids)}


class Phase(Enum):
    """The progress of the negotiation of a session's streams.

    IDLE: nothing was sent. CONFIGURING: CONFIGURE was sent, CONFIGURED has not arrived.
    CONFIGURED: the device has answered; its channels have no routes yet. STARTED: START was sent.
    """

    IDLE = auto()
    CONFIGURING = auto()
    CONFIGURED = auto()
    STARTED = auto()


class Streams:
    """A state machine without I/O for CONFIGURE, CHANNEL, CHANNEL_END, CONFIGURED and START.

    | phase | event | next phase |
    |---|---|---|
    | IDLE, CONFIGURED, STARTED | next_message() returns CONFIGURE | CONFIGURING |
    | CONFIGURING | configured() | CONFIGURED |
    | CONFIGURED | next_message() returns START | STARTED |
    | STARTED | announce(): an app's own topic needs another START | CONFIGURED |

    Methods raise ProtocolError when the device broke the protocol. Not thread-safe, except that
    the readers of lanes look up `routes` while next_message() adds to them.

    Args:
        table: all possible streams and topics.
        custom: the app's own topics by name; new ones are added, and it outlives the session.
        frame_prefix: the prefix of the headset's frame ids.

    Attributes:
        phase: how far the negotiation is.
        answers: the device's answer for each stream that was requested.
        routes: each lane's routes by channel.
    """

    def __init__(
        self, table: StreamTable, custom: dict[str, Topic], frame_prefix: str = ""
    ) -> None:
        self.phase = Phase.IDLE
        self.answers: Mapping[str, StreamAnswer] = {}
        self.routes: dict[str, dict[int, Route]] = {lane: {} for lane in table.lanes}
        self._table, self._custom = table, custom
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
        self._link: Link | None = None
        self._refusals: Mapping[str, StreamAnswer] = {}
        self._offered: list[Topic] = []
        self._has_started = self._is_streaming = False

    @property
    def topics(self) -> list[Topic]:
        """The topics of all streams that were not refused, running or not."""
        return [topic for topic in self._offered if self.answers[topic.stream].result != "refused"]

    @property
    def is_answered(self) -> bool:
        """True if the device has answered every request."""
        return self.phase in (Phase.CONFIGURED, Phase.STARTED)

    def is_running(self, topic: Topic) -> bool:
        """Returns True if the device is to send the topic at present. Thread-safe."""
        is_asked_for = self._is_streaming and topic.stream in self._requested
        return is_asked_for and topic in list(self._live.values())

    def states(self, status: Status | None) -> dict[str, StreamStatus]:
        """Returns the state of each stream: that of the last STATUS, or else the answered one."""
        return stream_states(self.answers, (status and status.streams) or {})

    def topic(self, name: str) -> Topic:
        """Returns the row of the stream table, or the app's own topic."""
        return self._topics.get(name) or self._custom[name]

    def renegotiate(self) -> None:
        """Makes next_message() request everything again, since the device would accept more."""
        if self.is_answered:
            self._negotiated = None

    def next_message(self, desired: DesiredStreams) -> Configure | Start | None:
        """Returns what to send next, or None if nothing is due or an answer is outstanding.

        A request is negotiated as a whole before any of it starts, so that all its answers and
        topics are known. The next CONFIGURE leaves out the streams that are not needed at present.
        """
        if self.phase is Phase.CONFIGURING:
            return None
        requested, refusals = desired.requested(), desired.refusals()
        if (self._negotiated, self._refusals) != (requested, refusals):
            self._negotiated, self._refusals = requested, refusals
            return self._configure(requested, desired.link)
        needed = self._needed(desired)
        if (needed, desired.link) != (self._requested, self._link):
            return self._configure(needed, desired.link)
        is_idle = not needed and self._negotiated
        if desired.is_paused or is_idle or self.phase is Phase.STARTED:
            return None
        return self._start()

    def _needed(self, desired: DesiredStreams) -> Request:
        if desired.is_paused:
            return {} if self._is_streaming else self._requested
        return {id: values for id, values in desired.requested().items() if id not in desired.idle}

    def _configure(self, streams: Request, link: Link | None) -> Configure:
        self._request += 1
        self._requested_before, self._requested = self._requested, streams
        self._link = link
        self._is_streaming = self._is_streaming and bool(streams)
        self.phase = Phase.CONFIGURING
        return Configure(self._request, streams, self._frame_prefix, link)

    def _start(self) -> Start:
        for channel, (lane, route) in self._unrouted.items():
            self.routes[lane][channel] = route
        self._unrouted.clear()
        self.phase = Phase.STARTED
        self._has_started = self._is_streaming = True
        is_open = self._table.custom_topics.stream in self._requested
        return Start(self._request, self._announced if is_open else None)

    def announce(self, channel: Channel) -> Topic:
        """Takes a CHANNEL and returns the topic to open; route() must follow."""
        if self.phase is Phase.IDLE:
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
        self._live[channel.id] = topic
        self._announced += 1
        if self.phase is Phase.STARTED:
            self.phase = Phase.CONFIGURED
        if self.is_answered and topic not in self._offered:
            self._offered.append(topic)
        return topic

    def route(self, channel: int, route: Route) -> None:
        """Sends the DATA of an announced channel along `route` from the next START on."""
        self._unrouted[channel] = self._live[channel].lane.name, route

    def _checked(self, channel: Channel) -> Topic:
        if channel.stream == self._table.custom_topics.stream:
            return self._checked_custom(channel)
        topic = self._topics.get(channel.topic)
        found = (channel.stream, channel.role, channel.type, channel.qos, channel.lane)
        if topic is None or found != (
            *(topic.stream, topic.role, topic.type, topic.qos),
            topic.lane.name,
        ):
            raise ProtocolError(
                ErrorCode.CHANNEL, f"the stream table has no {channel.topic!r} with {found!r}"
            )
        values = self._requested.get(topic.stream)
        if values is None or (topic.when is not None and not topic.when.holds(values)):
            raise ProtocolError(ErrorCode.CHANNEL, f"{topic.name} was not asked for")
        return topic

    def _checked_custom(self, channel: Channel) -> Topic:
        rules, known = self._table.custom_topics, self._custom
        topic = rules.topic(channel.topic, channel.type, channel.qos, channel.lane)
        if topic is None or channel.role != rules.role or channel.topic in self._topics:
            raise ProtocolError(
                ErrorCode.CHANNEL, f"no custom topic can be {channel.topic!r}: {channel!r}"
            )
        # The app announces it by itself, so CHANNEL may cross the CONFIGURE that excludes it.
        if rules.stream not in self._requested and (
            self.is_answered or rules.stream not in self._requested_before
        ):
            raise ProtocolError(ErrorCode.CHANNEL, f"{topic.name} was not asked for")
        if (before := known.get(topic.name, topic)) != topic:
            was, now = ((it.type, it.qos, it.lane.name) for it in (before, topic))
            raise ProtocolError(ErrorCode.CHANNEL, f"{topic.name} is {was}, not {now}")
        if topic.name not in known and len(known) >= rules.max_topics:
            raise ProtocolError(
                ErrorCode.CHANNEL, f"{topic.name} is one more than {rules.max_topics} custom topics"
            )
        return known.setdefault(topic.name, topic)

    def end(self, end: ChannelEnd) -> None:
        """Takes a CHANNEL_END; the route stays for DATA that is under way."""
        if self._live.pop(end.id, None) is None:
            raise ProtocolError(ErrorCode.CHANNEL, f"channel {end.id} is not announced")

    def configured(self, configured: Configured) -> None:
        """Takes CONFIGURED, which completes the announcements of a request."""
        if configured.request != self._request or self.phase is not Phase.CONFIGURING:
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
            self.answers, self._offered = {**configured.streams, **self._refusals}, live
        else:
            self.answers = {**self.answers, **configured.streams}
            self._offered += [topic for topic in live if topic not in self._offered]
        self.phase = Phase.CONFIGURED

    def data_error(self, channel: int) -> ProtocolError:
        """Returns the error for DATA of a channel that has no route."""
        if channel in self._unrouted or not self._has_started:
            return ProtocolError(ErrorCode.UNEXPECTED, f"DATA of channel {channel} before START")
        return ProtocolError(ErrorCode.CHANNEL, f"DATA of channel {channel}, unknown on this lane")
