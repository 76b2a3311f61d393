"""Messages of ROS on their way to the headset: queues, and what writes them."""

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

from ..wire.frame import encode_frame
from ..wire.kinds import ROS, Kind
from ..wire.opening_bodies import DEFAULT_DEPTH, Open, SubscriptionStatus
from .books import Books, SubscriptionReport

# What waits in all queues of a session together, in bytes.
_MOST_WAITING_BYTES = 16 << 20


class _Message(NamedTuple):
    source_ns: int
    payload: bytes
    number: int = 0


class SubscriptionQueue:
    """Where the graph puts the messages of one subscription, from any thread.

    Attributes:
        name, type: those of the topic.
        book: what became of its messages, together with those of an equal opening.
        ending: why the graph has ended it, and the code of CLOSED; None before.
    """

    def __init__(self, downlink: "Downlink", wanted: Open, name: str) -> None:
        self.id, self.name, self.type = wanted.id, name, wanted.type or ""
        self.is_latest = wanted.keep != "all"
        self.depth = 1 if self.is_latest else (wanted.depth or DEFAULT_DEPTH)
        self.ending: tuple[str, str] | None = None
        self.is_open = True
        self.waiting: deque[_Message] = deque()
        self._period_s = 1 / wanted.max_hz if wanted.max_hz else 0.0
        self._due_s = 0.0
        self._downlink = downlink
        self.book = downlink.books.open(name, self.type, wanted.received or 0)

    def put(self, payload: bytes, source_ns: int) -> None:
        """Takes a message that begins with CDR_ENCAPSULATION, published at this ROS time.

        Returns at once.
        """
        if not self._period_s or self._is_due(time.monotonic()):
            self._downlink.put(self, _Message(source_ns, payload))

    def _is_due(self, now_s: float) -> bool:
        if now_s < self._due_s:
            return False
        # Half a period of patience keeps the mean rate of a publisher that is not steady.
        self._due_s = max((self._due_s or now_s) + self._period_s, now_s + self._period_s / 2)
        return True

    def miss(self, count: int) -> None:
        """Counts messages that ROS lost."""
        with self._downlink.books.lock:
            self.book.missed += count


class Downlink:
    """The queues of one session, and the writer of its lane `ros`. Thread-safe.

    A message takes the place of its opening's oldest one where the queue is full. The openings take
    turns.

    Attributes:
        books: those of the instance.
        is_over: True after stop().
    """

    def __init__(self, books: Books) -> None:
        self.books = books
        self._changed = threading.Condition(books.lock)
        self._queues: dict[int, SubscriptionQueue] = {}
        self._last: list[SubscriptionQueue] = []  # those that were open when the session ended
        self._turns: deque[SubscriptionQueue] = deque()  # those with messages
        self._waiting_bytes = 0
        self.is_over = False

    def queue(self, wanted: Open, name: str) -> SubscriptionQueue:
        """Returns where to put the messages of a subscription, until close()."""
        queue = SubscriptionQueue(self, wanted, name)
        with self._changed:
            self._queues[queue.id] = queue
        return queue

    def put(self, queue: SubscriptionQueue, message: _Message) -> None:
        """Numbers a message, and queues it or counts why not."""
        with self._changed:
            if not queue.is_open:
                return
            book, waiting = queue.book, queue.waiting
            number, length = book.number(), len(message.payload)
            if length > ROS.max_payload_bytes:
                book.dropped["too_large"] += 1
                return
            if len(waiting) == queue.depth:
                self._drop_oldest(queue, "superseded" if queue.is_latest else "queue_full")
            if self._waiting_bytes + length > _MOST_WAITING_BYTES:
                book.dropped["queue_full"] += 1
            else:
                self._waiting_bytes += length
                waiting.append(message._replace(number=number))
            if waiting and queue not in self._turns:
                self._turns.append(queue)
                self._changed.notify()

    def _drop_oldest(self, queue: SubscriptionQueue, reason: str) -> None:
        self._waiting_bytes -= len(queue.waiting.popleft().payload)
        queue.book.dropped[reason] += 1

    def close(self, id: int, reason: str) -> None:
        """Ends an opening, if it is a subscription; what waits is dropped for this reason."""
        with self._changed:
            queue = self._queues.pop(id, None)
            if queue is None:
                return
            queue.is_open = False
            self.books.leave(queue.book)
            if reason == "link_down":
                self._last.append(queue)
            while queue.waiting:
                self._drop_oldest(queue, reason)

    def reports(self, counted: Mapping[str, SubscriptionStatus]) -> list[SubscriptionReport]:
        """Returns the subscriptions that are open, or were when the session ended."""
        with self._changed:
            return [
                SubscriptionReport(it.id, it.name, it.type, it.book.copy(), counted.get(str(it.id)))
                for it in (*self._queues.values(), *self._last)
            ]

    def endings(self) -> list[tuple[int, tuple[str, str]]]:
        """Returns the openings that the graph has ended, with the reasons and codes of CLOSED."""
        with self._changed:
            queues = self._queues.values()
            return [(it.id, it.ending) for it in queues if it.ending is not None]

    def stop(self) -> None:
        """Ends write()."""
        with self._changed:
            self.is_over = True
            self._changed.notify_all()

    def write(self, send_all: Callable[[bytes], None]) -> None:
        """Sends what is put, until stop() or until the connection is broken."""
        while (taken := self._take()) is not None:
            queue, message = taken
            frame = encode_frame(
                Kind.MESSAGE,
                message.payload,
                channel=queue.id,
                sequence=message.number,
                capture_ns=message.source_ns,
                send_ns=time.time_ns(),
            )
            try:
                send_all(frame)
            except OSError:  # which the reader of the lane notices
                with self._changed:
                    queue.book.dropped["link_down"] += 1
                return
            with self._changed:
                queue.book.wrote(message.number)

    def _take(self) -> tuple[SubscriptionQueue, _Message] | None:
        with self._changed:
            while not self.is_over:
                if not self._turns:
                    self._changed.wait()
                    continue
                queue = self._turns.popleft()
                if not queue.waiting:
                    continue
                message = queue.waiting.popleft()
                self._waiting_bytes -= len(message.payload)
                if queue.waiting:
                    self._turns.append(queue)
                return queue, message
            return None
