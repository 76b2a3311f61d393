"""The device side of one session, without I/O."""

from collections.abc import Mapping, Sequence

from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import (
    Channel,
    ChannelEnd,
    ChannelStatus,
    ClockStatus,
    Configure,
    Configured,
    Hello,
    Join,
    Start,
    Status,
    StreamAnswer,
    Welcome,
)

type Reply = Channel | ChannelEnd | Configured


class Device:
    """Numbers channels and messages, and makes the bodies that a device sends.

    One object serves all sessions; its numbers continue in the next session. Not thread-safe,
    except that another thread may read `live` and call data_header().

    Attributes:
        hello: the body of HELLO.
        welcome: the receiver's answer, once there is one.
        announced: the topics that have a channel now.
        live: the topics whose DATA the receiver takes now.
        channels: the number of each topic's channel.
        sent: the number of messages produced for each topic.
    """

    welcome: Welcome

    def __init__(self, hello: Hello) -> None:
        self.hello = hello
        self.announced: frozenset[Topic] = frozenset()
        self.live: frozenset[Topic] = frozenset()
        self.channels: dict[Topic, int] = {}
        self.sent: dict[Topic, int] = {}
        self._request = 0

    @property
    def is_configured(self) -> bool:
        """True if the receiver has sent CONFIGURE in this session."""
        return bool(self._request)

    def begin(self, welcome: Welcome) -> None:
        """Begins a session with the receiver's WELCOME."""
        self.welcome = welcome
        self.announced = self.live = frozenset()
        self._request = 0

    def join(self, lane: str) -> Join:
        """Returns the body of JOIN for a lane of this session."""
        return Join(self.welcome.session, self.welcome.tickets.get(lane, ""), lane)

    def configure(
        self, configure: Configure, topics: Sequence[Topic], answers: Mapping[str, StreamAnswer]
    ) -> list[Reply]:
        """Returns what answers CONFIGURE, in the order in which to send it.

        Args:
            configure: the receiver's request.
            topics: the topics that the device sends from the next START on.
            answers: the answer for each requested stream.
        """
        self._request = configure.request
        self.live &= frozenset(topics)
        replies: list[Reply] = [
            ChannelEnd(self.channels[topic]) for topic in self.announced.difference(topics)
        ]
        replies += [self.announce(topic) for topic in topics if topic not in self.announced]
        self.announced = frozenset(topics)
        return [*replies, Configured(configure.request, answers)]

    def announce(self, topic: Topic) -> Channel:
        """Returns the body of CHANNEL; the topic keeps its channel number in all sessions."""
        self.announced |= {topic}
        return channel(topic, self.channels.setdefault(topic, len(self.channels) + 1))

    def start(self, start: Start) -> bool:
        """Takes START; returns False if it is for an earlier request."""
        if start.request != self._request:
            return False
        self.live = self.announced
        return True

    def refuse(self, number: int | None) -> list[Topic]:
        """Stops the topics of a channel that the receiver refuses, and returns them."""
        refused = [topic for topic, it in self.channels.items() if it == number]
        self.live -= frozenset(refused)
        return refused

    def data_header(
        self, topic: Topic, capture_ns: int, send_ns: int, dropped: int = 0
    ) -> dict[str, int]:
        """Returns the header fields of the topic's next DATA frame, after `dropped` messages."""
        sequence = self.sent.get(topic, 0) + dropped
        self.sent[topic] = sequence + 1
        return {
            "channel": self.channels[topic],
            "sequence": sequence,
            "capture_ns": capture_ns,
            "send_ns": send_ns,
        }

    def status(self, uptime_s: float, clock: ClockStatus, *, is_final: bool) -> Status:
        """Returns the body of STATUS."""
        counts = {topic.name: self.sent.get(topic, 0) for topic in self.channels.copy()}
        channels = {name: ChannelStatus(count, count, {}) for name, count in counts.items()}
        return Status(is_final, uptime_s, channels, clock)


def channel(topic: Topic, number: int) -> Channel:
    """Returns the body of CHANNEL for a row of the stream table."""
    return Channel(
        number,
        topic.stream,
        topic.role,
        topic.name,
        topic.type,
        topic.qos,
        topic.frame,
        topic.lane.name,
    )


KINDS: dict[type[Reply], Kind] = {
    Channel: Kind.CHANNEL,
    ChannelEnd: Kind.CHANNEL_END,
    Configured: Kind.CONFIGURED,
}
