"""The queue of one subscription, and its messages."""

import mmap
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from ..wire.frame import HEADER_BYTES, encode_header
from ..wire.kinds import Kind, Lane
from ..wire.opening_bodies import DEFAULT_DEPTH, Open
from .books import Books

type Payload = bytes | bytearray | mmap.mmap
type Pieces = Iterable[bytes | memoryview]

# So much of a large message is copied behind its header.
_COPIED_BYTES = (16 << 10) - HEADER_BYTES


class Message(NamedTuple):
    """A payload, with its time of publication and its number."""

    source_ns: int
    payload: Payload
    number: int = 0

    def pieces(self, id: int) -> Iterator[bytes | memoryview]:
        """Yields its frame in two pieces, if it is large. Only the first one is copied."""
        length, view = len(self.payload), memoryview(self.payload)
        header = encode_header(
            Kind.MESSAGE,
            length,
            channel=id,
            sequence=self.number,
            capture_ns=self.source_ns,
            send_ns=time.time_ns(),
        )
        yield header + view[:_COPIED_BYTES]
        if length > _COPIED_BYTES:
            yield view[_COPIED_BYTES:]


class SubscriptionQueue:
    """The queue into which the graph puts the messages of one subscription. Thread-safe.

    Attributes:
        name, type: those of the topic.
        lane: where its messages go.
        book: what became of its messages, together with those of an equal opening.
        ending: why the graph has ended it, and the code of CLOSED; None before.
    """

    def __init__(
        self,
        put: Callable[["SubscriptionQueue", Message], None],
        books: Books,
        wanted: Open,
        name: str,
        lane: Lane,
    ) -> None:
        self.id, self.name, self.type, self.lane = wanted.id, name, wanted.type or "", lane
        self.is_latest = wanted.keep != "all"
        self.depth = 1 if self.is_latest else (wanted.depth or DEFAULT_DEPTH)
        self.ending: tuple[str, str] | None = None
        self.is_open = True
        self.waiting: deque[Message] = deque()
        self._period_s = 1 / wanted.max_hz if wanted.max_hz else 0.0
        self._due_s = 0.0
        self._put, self._books = put, books
        self.book = books.open(name, self.type, wanted.received or 0)

    def put(self, payload: Payload, source_ns: int) -> None:
        """Takes a message that begins with CDR_ENCAPSULATION, published at this ROS time.

        Returns at once.
        """
        if not self._period_s or self._is_due(time.monotonic()):
            self._put(self, Message(source_ns, payload))

    def _is_due(self, now_s: float) -> bool:
        if now_s < self._due_s:
            return False
        # Half a period of patience keeps the mean rate of a publisher that is not steady.
        self._due_s = max((self._due_s or now_s) + self._period_s, now_s + self._period_s / 2)
        return True

    def miss(self, count: int) -> None:
        """Counts messages that ROS lost."""
        with self._books.lock:
            self.book.missed += count
