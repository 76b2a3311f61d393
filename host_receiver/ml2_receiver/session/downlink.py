"""Messages of ROS on their way to the headset: queues, and what writes them."""

import itertools
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import NamedTuple

from ..pacing import Pacing
from ..wire.frame import encode_frame
from ..wire.kinds import BULK_LANES, ROS, ROS_LANES, Kind, Lane
from ..wire.opening_bodies import Open, SubscriptionStatus
from .books import Books, SubscriptionReport
from .subscription_queue import Message, Pieces, SubscriptionQueue

# Maximum bytes in all queues of a session together: on `ros`, and on the lanes `bulk_N`.
_MOST_WAITING_BYTES = {True: 16 << 20, False: 64 << 20}
# Messages on `ros` that wait are written together up to so much: each call of the transport waits
# for the interpreter, and makes a record of TLS.
_TOGETHER_BYTES = 16 << 10
# Maximum messages of an opening, and bytes of a session, that the app has not taken.
_MOST_UNTAKEN, _MOST_UNTAKEN_BYTES = 2, 128 << 20

type _Taken = tuple[SubscriptionQueue, Message]


class _Ahead(NamedTuple):
    """A frame that goes before messages."""

    kind: Kind
    body: bytes
    header: Mapping[str, int]


class _Turns(deque[SubscriptionQueue]):
    """The queues of one lane that have messages; `changed` is told of new ones."""

    def __init__(self, lock: threading.Lock) -> None:
        super().__init__()
        self.changed = threading.Condition(lock)


class Downlink:
    """The queues of one session, and the writers of `ros` and `bulk_1` to `bulk_4`. Thread-safe.

    A message takes the place of its opening's oldest one where the queue is full. The openings of a
    lane take turns.

    Attributes:
        books: those of the instance.
        sending: is called with the opening and the number of each message on `bulk_N`, before it is
            sent.
        is_over: True after stop().
        pacing: that of what is sent on `bulk_N`.
        begins: is told the kind, opening and number of each frame that does not carry a message,
            before it is written; returns False if it is not to be sent any more.
    """

    def __init__(self, books: Books) -> None:
        self.books = books
        self.sending: Callable[[int, int], None] = lambda *_: None
        self._lock = books.lock
        self._queues: dict[int, SubscriptionQueue] = {}
        self._last: list[SubscriptionQueue] = []  # those that were open when the session ended
        self._turns = {lane.name: _Turns(self._lock) for lane in ROS_LANES}
        self._waiting_bytes = {True: 0, False: 0}
        # Numbers and lengths of what the app has not taken, also of openings that have ended
        self._untaken: dict[int, deque[tuple[int, int]]] = {}
        self._ahead: deque[_Ahead] = deque()
        self._ended: dict[int, tuple[str, str]] = {}
        self.is_over = False
        self.pacing = Pacing(lambda: self.is_over)
        self.begins: Callable[[Kind, int, int], bool] = lambda *_: True

    def queue(self, wanted: Open, name: str, *, is_bulk: bool = False) -> SubscriptionQueue:
        """Returns where to put the messages of a subscription, until close()."""
        with self._lock:
            used = [it.lane for it in self._queues.values()]
        lane = min(BULK_LANES, key=used.count) if is_bulk else ROS
        queue = SubscriptionQueue(self.put, self.books, wanted, name, lane)
        with self._lock:
            self._queues[queue.id] = queue
        return queue

    def put(self, queue: SubscriptionQueue, message: Message) -> None:
        """Numbers a message, and queues it or counts why not."""
        with self._lock:
            if not queue.is_open:
                return
            book, waiting, lane = queue.book, queue.waiting, queue.lane
            number, length = book.number(), len(message.payload)
            if length > lane.max_payload_bytes:
                book.dropped["too_large"] += 1
                return
            if len(waiting) == queue.depth:
                self._drop_oldest(queue, "superseded" if queue.is_latest else "queue_full")
            together = self._waiting_bytes[lane.is_urgent] + length
            if together > _MOST_WAITING_BYTES[lane.is_urgent]:
                book.dropped["queue_full"] += 1
            else:
                self._waiting_bytes[lane.is_urgent] = together
                waiting.append(message._replace(number=number))
            turns = self._turns[lane.name]
            if waiting and queue not in turns:
                turns.append(queue)
                turns.changed.notify()

    def _pop(self, queue: SubscriptionQueue) -> Message:
        message = queue.waiting.popleft()
        self._waiting_bytes[queue.lane.is_urgent] -= len(message.payload)
        return message

    def _drop_oldest(self, queue: SubscriptionQueue, reason: str) -> None:
        self._pop(queue)
        queue.book.dropped[reason] += 1

    def taken(self, id: int, number: int) -> None:
        """Takes which message of an opening on `bulk_N` the app has taken last."""
        with self._lock:
            untaken = self._untaken.get(id, deque())
            while untaken and (number - untaken[0][0]) % (1 << 32) < 1 << 31:
                untaken.popleft()
            if not untaken:
                self._untaken.pop(id, None)
            for lane in BULK_LANES:  # the bound of all openings may have held any of them
                self._turns[lane.name].changed.notify()

    def close(self, id: int, reason: str) -> None:
        """Ends an opening, if it is a subscription; what waits is dropped for this reason."""
        with self._lock:
            self._ended.pop(id, None)
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
        with self._lock:
            return [
                SubscriptionReport(it.id, it.name, it.type, it.book.copy(), counted.get(str(it.id)))
                for it in (*self._queues.values(), *self._last)
            ]

    def endings(self) -> list[tuple[int, tuple[str, str]]]:
        """Returns the openings that the graph has ended, with the reasons and codes of CLOSED."""
        with self._lock:
            queues = self._queues.values()
            endings = [(it.id, it.ending) for it in queues if it.ending is not None]
            endings += self._ended.items()
            self._ended.clear()
            return endings

    def end(self, id: int, reason: str, code: str) -> None:
        """Ends an opening that has no queue, soon."""
        with self._lock:
            self._ended[id] = reason, code

    def send(
        self,
        kind: Kind,
        id: int,
        number: int,
        body: bytes,
        capture_ns: int = 0,
        *,
        is_latest: bool = False,
    ) -> None:
        """Sends a request, an answer or a pose, before the messages that wait.

        Only so many wait as the openings allow to be under way; one that `is_latest` takes the
        place of its opening's last one.
        """
        header = {"channel": id, "sequence": number, "capture_ns": capture_ns}
        with self._lock:
            if is_latest:
                for old in [it for it in self._ahead if it.header["channel"] == id]:
                    self._ahead.remove(old)
            self._ahead.append(_Ahead(kind, body, header))
            self._turns[ROS.name].changed.notify()

    def stop(self) -> None:
        """Ends write() of all lanes."""
        with self._lock:
            self.is_over = True
            for turns in self._turns.values():
                turns.changed.notify_all()

    def write(self, lane: Lane, send_all: Callable[[Pieces], None]) -> None:
        """Sends what is put for a lane, until stop() or until the connection is broken.

        Args:
            send_all: sends a frame, given in pieces.
        """
        while (taken := self._take(lane)) is not None:
            if isinstance(taken, _Ahead):
                self._send_ahead(taken, send_all)
                continue
            if lane is not ROS:
                for queue, message in taken:
                    self.sending(queue.id, message.number)
            try:
                send_all(_pieces(taken))
            except OSError:  # which the reader of the lane notices
                with self._lock:
                    for queue, _ in taken:
                        queue.book.dropped["link_down"] += 1
                return
            with self._lock:
                for queue, message in taken:
                    queue.book.wrote(message.number)

    def _send_ahead(self, frame: _Ahead, send_all: Callable[[Pieces], None]) -> None:
        kind, body, header = frame
        if self.begins(kind, header["channel"], header["sequence"]):
            with suppress(OSError):  # which the reader of the lane notices
                send_all([encode_frame(kind, body, **header, send_ns=time.time_ns())])

    def _take(self, lane: Lane) -> list[_Taken] | _Ahead | None:
        turns = self._turns[lane.name]
        with self._lock:
            while not self.is_over:
                if lane is ROS and self._ahead:
                    return self._ahead.popleft()
                if taken := self._take_small(turns) if lane is ROS else self._take_large(turns):
                    return taken
                turns.changed.wait()
            return None

    def _take_small(self, turns: _Turns) -> list[_Taken]:
        taken: list[_Taken] = []
        room = _TOGETHER_BYTES
        while turns:
            queue = turns.popleft()
            if not queue.waiting:
                continue
            room -= len(queue.waiting[0].payload)
            if taken and room < 0:
                turns.appendleft(queue)
                break
            taken.append((queue, self._pop(queue)))
            if queue.waiting:
                turns.append(queue)
        return taken

    def _take_large(self, turns: _Turns) -> list[_Taken]:
        for queue in list(turns):
            turns.popleft()
            if not queue.waiting:
                continue
            turns.append(queue)
            if self._has_credit(queue.id, queue.waiting[0]):
                return [(queue, self._pop(queue))]
        return []

    def _has_credit(self, id: int, message: Message) -> bool:
        """Takes note of the message if it may be sent now."""
        length = len(message.payload)
        untaken = self._untaken.setdefault(id, deque())
        together = sum(it for numbers in self._untaken.values() for _, it in numbers) + length
        if len(untaken) == _MOST_UNTAKEN or together > _MOST_UNTAKEN_BYTES:
            return False
        untaken.append((message.number, length))
        return True


def _pieces(taken: list[_Taken]) -> Pieces:
    frames = [message.pieces(queue.id) for queue, message in taken]
    return frames[0] if len(frames) == 1 else [b"".join(itertools.chain(*frames))]
