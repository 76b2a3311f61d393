"""The counters and times of the messages of each topic, for one run of a device's app."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..table.stream_table import Topic
from ..wire.frame import Header
from ..wire.messages import ChannelStatus
from .books import Books

# The shares of a message's latency, between the columns of TopicStatistics.times_ns().
SHARES = ("capture_to_sent", "sent_to_received", "received_to_published")
_WINDOW = 512
# Twice the window, so that none of it is overwritten while it is copied.
_RING = 2 * _WINDOW
_TIMES = struct.Struct("=qqqq")
# A number this far ahead of the expected one is an old number: 2^31 or more ahead of the last.
_OLD = (1 << 31) - 1
_MASK = (1 << 32) - 1
_NOTHING = ChannelStatus(0, 0, {})


@dataclass(frozen=True)
class Latency:
    """The latency of some messages in ms; negative if the clocks disagree.

    Attributes:
        jitter_ms: mean absolute difference between one message and the next; RFC 3550, 6.4.1,
            has the same differences, smoothed.
    """

    p50_ms: float
    p99_ms: float
    jitter_ms: float

    @classmethod
    def of(cls, latencies_ms: NDArray[np.float64]) -> Self:
        """Returns the latency of at least one message, in order of arrival.

        The percentiles are interpolated, as np.percentile does, which takes three times as long.
        """
        ranks = np.linspace(0, 100, len(latencies_ms))
        p50_ms, p99_ms = np.interp((50, 99), ranks, np.sort(latencies_ms))
        jitter_ms = np.abs(np.diff(latencies_ms)).mean() if len(latencies_ms) > 1 else 0.0
        return cls(float(p50_ms), float(p99_ms), float(jitter_ms))


class TopicStatistics:
    """The counters of one topic over all sessions of an instance; memory does not grow.

    What the device counted `before`, when this receiver met it, was another receiver's.

    Only the reader thread of the topic's lane may record. Any thread may read; each number is
    right, but two of them may be from different moments.

    Attributes:
        received: messages that arrived.
        received_bytes: bytes of their payloads.
        produced: messages the device must have produced, as the sequence numbers tell.
        gaps: messages below `produced` that never arrived at this receiver.
        unpublished: messages that arrived but that ROS, or the recording, did not take.
    """

    def __init__(self, before: ChannelStatus = _NOTHING) -> None:
        self._before = before
        # Messages that were queued then are this receiver's
        self._first = before.sent + sum(before.dropped.values())
        self.received = 0
        self.received_bytes = 0
        self.produced = 0
        self.gaps = 0  # counted, as `produced - received` is 1 too high during record()
        self.unpublished = 0
        self._ring = bytearray(_TIMES.size * _RING)
        self._times = np.frombuffer(self._ring, np.int64).reshape(_RING, 4)

    def record(self, header: Header, received_ns: int, published_ns: int) -> bool:
        """Counts a message, or returns False if its number is not new.

        Both times are ROS time; at `published_ns` the message is handed to ROS.
        """
        ahead = (header.sequence - self._first - self.produced) & _MASK
        if ahead >= _OLD and self.received:
            return False
        place = self.received % _RING * _TIMES.size
        times = header.capture_ns, header.send_ns, received_ns, published_ns
        _TIMES.pack_into(self._ring, place, *times)
        self.produced += ahead + 1
        self.gaps += ahead
        self.received_bytes += header.length
        self.received += 1
        return True

    @property
    def last_number(self) -> int:
        """The sequence number of the newest message that arrived."""
        return (self._first + self.produced - 1) & _MASK

    def of_this_receiver(self, device: ChannelStatus) -> ChannelStatus:
        """Returns what the device counted since this receiver met it."""
        dropped = {
            reason: max(count - self._before.dropped.get(reason, 0), 0)
            for reason, count in device.dropped.items()
        }
        return ChannelStatus(
            max(device.produced - self._first, 0),
            max(device.sent - self._before.sent, 0),
            {reason: count for reason, count in dropped.items() if count},
        )

    def times_ns(self, first: int, end: int) -> NDArray[np.int64]:
        """Returns the times of the messages `first` to `end` - 1, or of the last 512 of them.

        Messages are counted from 0 in order of arrival. Each row is a message; the columns are
        capture, send, received and published, in ns of ROS time.
        """
        numbers = np.arange(max(first, end - _WINDOW), end)
        return self._times.take(numbers, axis=0, mode="wrap")

    def latency(self) -> Latency | None:
        """Returns the time from capture to arrival of the last 512 messages; None before any."""
        times_ns = self.times_ns(0, self.received)
        return Latency.of((times_ns[:, 2] - times_ns[:, 0]) / 1e6) if len(times_ns) else None


@dataclass(frozen=True)
class Instance:
    """One run of a device's app. Instances are equal if both ids are.

    `topics` is keyed by topic name as in the stream table; `custom` has the topics that the device
    named itself. `before` is what it had counted when this receiver met it. `books` are of what it
    was sent.
    """

    device_id: str
    instance_id: str
    before: Mapping[str, ChannelStatus] = field(default_factory=dict, compare=False)
    topics: dict[str, TopicStatistics] = field(default_factory=dict, compare=False)
    custom: dict[str, Topic] = field(default_factory=dict, compare=False)
    books: Books = field(default_factory=Books, compare=False)

    def received_bytes(self) -> int:
        """Returns the bytes of all payloads that arrived."""
        return sum(topic.received_bytes for topic in self.topics.values())

    def statistics(self, topic: str) -> TopicStatistics:
        """Returns the counters of a topic, which begin with the first call."""
        before = self.before.get(topic, _NOTHING)
        return self.topics.setdefault(topic, TopicStatistics(before))

    def received(self) -> dict[str, int]:
        """Returns the number of messages by topic that arrived here, or went to others before."""
        counts = {name: before.sent for name, before in self.before.items()}
        for name, topic in self.topics.items():
            counts[name] = counts.get(name, 0) + topic.received
        return counts
