"""What arrived of each topic of one app instance."""

from array import array
from dataclasses import dataclass, field

_LATENCIES = 512
# A number this far ahead of the next one is an old one: 2^31 or more from the last.
_OLD = (1 << 31) - 1
_MASK = (1 << 32) - 1


@dataclass(frozen=True)
class Latency:
    """Capture to arrival over the last 512 messages, in ms; negative when the clocks disagree."""

    p50_ms: float
    p99_ms: float


class TopicStatistics:
    """Counts of one topic over the sessions of an instance; memory does not grow.

    One lane's thread records. Any thread may read, each number by itself is right.

    Attributes:
        received: messages that arrived.
        received_bytes: bytes of their payloads.
        produced: messages the device must have produced, as the sequence numbers tell.
        unpublished: messages that arrived but that ROS did not take.
    """

    def __init__(self) -> None:
        self.received = 0
        self.received_bytes = 0
        self.produced = 0
        self.unpublished = 0
        self._latencies_ns = array("q", bytes(8 * _LATENCIES))

    @property
    def gaps(self) -> int:
        """Messages below `produced` that never arrived at this receiver."""
        return self.produced - self.received

    def record(self, sequence: int, length: int, latency_ns: int) -> bool:
        """A message of `length` bytes arrived; False, uncounted, if its number is not a new one."""
        ahead = (sequence - self.produced) & _MASK
        if ahead >= _OLD and self.received:
            return False
        self._latencies_ns[self.received % _LATENCIES] = latency_ns
        self.produced += ahead + 1
        self.received_bytes += length
        self.received += 1
        return True

    def latency(self) -> Latency | None:
        """None before the first message."""
        values = sorted(self._latencies_ns[: self.received])
        if not values:
            return None
        last = len(values) - 1
        return Latency(values[round(0.5 * last)] / 1e6, values[round(0.99 * last)] / 1e6)


@dataclass(frozen=True)
class Instance:
    """One run of a device's app; `topics` is keyed as the stream table names topics.

    Instances are equal when they are the same run.
    """

    device_id: str
    instance_id: str
    topics: dict[str, TopicStatistics] = field(default_factory=dict, compare=False)

    def received(self) -> dict[str, int]:
        """Messages that arrived, by topic."""
        return {name: topic.received for name, topic in self.topics.items()}
