"""The books of messages of ROS for the headset: numbers, and what became of each message."""

import threading
from collections import Counter, OrderedDict, deque
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Self

from ..wire.opening_bodies import SubscriptionStatus

_MASK = (1 << 32) - 1
_HALF = 1 << 31
# More than the buffers of a connection hold, unless each second message is left out.
_MOST_RUNS = 512
# Names and types of an instance whose numbers are remembered.
_MOST_BOOKS = 256


@dataclass
class Book:
    """Counts what became of the messages of one name and type, over all sessions of an instance.

    produced = sent + waiting + the sum of `dropped`. Used under the lock of Books.

    Attributes:
        first: the number of the first message.
        missed: what ROS lost before the receiver took it, as far as its numbers show.
        runs: first and last number of those sent, as far as they may still be on the way.
    """

    first: int
    produced: int = 0
    sent: int = 0
    missed: int = 0
    dropped: Counter[str] = field(default_factory=Counter)
    runs: deque[list[int]] = field(default_factory=lambda: deque(maxlen=_MOST_RUNS))
    users: int = 0

    def number(self) -> int:
        """Counts a message, and returns its number."""
        number = (self.first + self.produced) & _MASK
        self.produced += 1
        return number

    @property
    def waiting(self) -> int:
        """The messages in queues, and the one that is being written."""
        return self.produced - self.sent - self.dropped.total()

    def wrote(self, number: int) -> None:
        """Counts a message as sent."""
        self.sent += 1
        if self.runs and self.runs[-1][1] == (number - 1) & _MASK:
            self.runs[-1][1] = number
        else:
            self.runs.append([number, number])

    def copy(self) -> Self:
        """Returns the present counts."""
        return replace(self, dropped=Counter(self.dropped), runs=deque())

    def skip_to(self, expected: int) -> None:
        """Gives no number below the one that a headset expects: it got those of others."""
        if 0 < (expected - self.first - self.produced) & _MASK < _HALF:
            self.first = (expected - self.produced) & _MASK

    def resume(self, expected: int) -> None:
        """Takes which number the headset expects next: what was sent of that and later is lost."""
        lost = 0
        for first, last in self.runs:
            if (last - expected) & _MASK < _HALF:
                begin = first if (first - expected) & _MASK < _HALF else expected
                lost += ((last - begin) & _MASK) + 1
        self.runs.clear()
        self.sent -= lost
        if lost:
            self.dropped["link_down"] += lost


class SubscriptionReport(NamedTuple):
    """A subscription of the app; `device` is from the last STATUS."""

    id: int
    name: str
    type: str
    book: Book
    device: SubscriptionStatus | None


class Books:
    """The books of one instance. The lock is that of its books, and of what is queued."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self._books: OrderedDict[tuple[str, str], Book] = OrderedDict()

    def open(self, name: str, type: str, expected: int) -> Book:
        """Returns a book for one more opening, whose next number shall be at least `expected`."""
        with self.lock:
            book = self._books.setdefault((name, type), Book(expected))
            self._books.move_to_end((name, type))
            if not book.users:
                book.resume(expected)
            book.skip_to(expected)
            book.users += 1
            unused = [key for key, it in self._books.items() if not it.users]
            for key in unused[: max(0, len(self._books) - _MOST_BOOKS)]:
                del self._books[key]
            return book

    def __len__(self) -> int:
        return len(self._books)

    def leave(self, book: Book) -> None:
        """Ends an opening of the book. Call it under the lock."""
        book.users -= 1
