"""What arrived of each topic of one app instance, and when."""

import struct
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..table.stream_table import Topic
from ..wire.frame import Header

# The shares of a message's latency, between the columns of TopicStatistics.times_ns().
SHARES = ("capture_to_sent", "sent_to_received", "received_to_published")
_WINDOW = 512
# Twice the window, so that none of it is overwritten while it is copied.
_RING = 2 * _WINDOW
_TIMES = struct.Struct("=qqqq")
# A number this far ahead of the next one is an old one: 2^31 or more from the last.
_OLD = (1 << 31) - 1
_MASK = (1 << 32) - 1


@dataclass(frozen=True)
class Latency:
    """Of some messages, in ms; negative when the clocks disagree.

    Attributes:
        jitter_ms: mean absolute difference between one message and the next; RFC 3550, 6.4.1,
            has the same differences, smoothed.
    """

    p50_ms: float
    p99_ms: float
    jitter_ms: float

    @classmethod
    def of(cls, latencies_ms: NDArray[np.float64]) -> Self:
        """Of at least one message, in the order of their arrival; percentiles interpolate."""
        p50_ms, p99_ms = np.percentile(latencies_ms, (50, 99))
        jitter_ms = np.abs(np.diff(latencies_ms)).mean() if len(latencies_ms) > 1 else 0.0
        return cls(float(p50_ms), float(p99_ms), float(jitter_ms))


class TopicStatistics:
    """Counts of one topic over the sessions of an instance; memory does not grow.

    One lane's thread records. Any thread may read, each number by itself is right.

    Attributes:
        received: messages that arrived.
        received_bytes: bytes of their payloads.
        produced: messages the device must have produced, as the sequence numbers tell.
        gaps: messages below `produced` that never arrived at this receiver.
        unpublished: messages that arrived but that ROS, or the recording, did not take.
    """

    def __init__(self) -> None:
        self.received = 0
        self.received_bytes = 0
        self.produced = 0
        self.gaps = 0  # not produced - received, which is one more while a message is recorded
        self.unpublished = 0
        self._ring = bytearray(_TIMES.size * _RING)
        self._times = np.frombuffer(self._ring, np.int64).reshape(_RING, 4)

    def record(self, header: Header, received_ns: int, published_ns: int) -> bool:
        """A message arrived; False, uncounted, if its number is not a new one.

        `published_ns` is when it is handed to ROS; both are ROS time.
        """
        ahead = (header.sequence - self.produced) & _MASK
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

    def times_ns(self, first: int, end: int) -> NDArray[np.int64]:
        """Columns capture, send, received, published of the messages that arrived as number
        `first` up to `end`, counted from 0: a row each, at most the last 512."""
        return self._times[np.arange(max(first, end - _WINDOW), end) % _RING]

    def latency(self) -> Latency | None:
        """Capture to arrival of the last 512 messages; None before the first."""
        times_ns = self.times_ns(0, self.received)
        return Latency.of((times_ns[:, 2] - times_ns[:, 0]) / 1e6) if len(times_ns) else None


@dataclass(frozen=True)
class Instance:
    """One run of a device's app; `topics` is keyed as the stream table names topics, `custom` has
    the rows of those that the device has named itself.

    Instances are equal when they are the same run.
    """

    device_id: str
    instance_id: str
    topics: dict[str, TopicStatistics] = field(default_factory=dict, compare=False)
    custom: dict[str, Topic] = field(default_factory=dict, compare=False)

    def received_bytes(self) -> int:
        """Payloads that arrived, of all topics."""
        return sum(topic.received_bytes for topic in self.topics.values())

    def received(self) -> dict[str, int]:
        """Messages that arrived, by topic."""
        return {name: topic.received for name, topic in self.topics.items()}
