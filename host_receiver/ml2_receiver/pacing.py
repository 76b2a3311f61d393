"""Bounds what large messages to the headset have under way; ARCHITECTURE.md, Pacing."""

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

_POLL_S = 0.0005
# The delay that large messages may add to the path, and no more than that: images of the headset,
# whose acknowledgements come back behind them, take 6 ms for a queue of their own.
_QUEUE_S = 0.003
# The shortest is more than its last two segments, which TCP acknowledges 40 ms late. It is written
# where the longest alone would be a queue of 4 ms.
_LEAST_SLICE_BYTES, _MOST_SLICE_BYTES = 8 << 10, 16 << 10
# Images come in bursts, 30 times a second: a shorter time has none, in which the link seems free.
_MEAN_S = 0.07
_WINDOW_S, _INTERVAL_S, _REST_S = 0.2, 0.002, 0.02


class SendQueue(Protocol):
    """The bytes of a connection that the kernel keeps until the peer acknowledges them."""

    def unacknowledged(self) -> int:
        """Returns their number; 0 when the connection is closed."""

    def least_round_trip_s(self) -> float:
        """Returns the least round trip of the connection."""


class Pacing:
    """Lets the lanes of one session write in slices. Thread-safe.

    A slice is written while less is under way than the link delivers in its least round trip and
    3 ms. A link with room then delivers more at each round trip, so the bound grows until the link
    has a queue of 3 ms. Images of the headset that share the link, as in the air of Wi-Fi, lower
    the bound with what is delivered.

    Args:
        is_over: returns True when nothing is to wait any more.
    """

    def __init__(
        self,
        is_over: Callable[[], bool],
        now_s: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._is_over, self._now_s, self._sleep = is_over, now_s, sleep
        self._turn, self._lock = threading.Lock(), threading.Lock()
        self._queues: list[SendQueue] = []
        self._granted = self._written = 0
        self._slice_bytes = _MOST_SLICE_BYTES
        self._asked_s = now_s()
        # Times in s, with the bytes acknowledged by then, and with rates that none later exceeds
        self._totals: deque[tuple[float, int]] = deque()
        self._rates: deque[tuple[float, float]] = deque()

    def add(self, queue: SendQueue) -> None:
        """Paces one more connection."""
        with self._lock:
            self._queues.append(queue)

    def send(self, data: bytes | memoryview, send_all: Callable[[memoryview], None]) -> None:
        """Sends data in slices."""
        view = memoryview(data)
        while view:
            piece = view[: self._slice_bytes]
            self.wait(len(piece))
            try:
                send_all(piece)
            finally:
                self.written(len(piece))
            view = view[len(piece) :]

    def wait(self, length: int) -> None:
        """Waits until a slice may be written; call written() afterwards."""
        with self._turn:
            while not self._may_write() and not self._is_over():
                self._sleep(_POLL_S)
            with self._lock:
                self._granted += length

    def written(self, length: int) -> None:
        """Takes note that a slice was handed to the kernel, or its connection was lost."""
        with self._lock:
            self._granted -= length
            self._written += length

    def _may_write(self) -> bool:
        with self._lock:
            waiting = sum(it.unacknowledged() for it in self._queues)
            delivered = self._delivered(self._written - waiting)
            least_s = min((it.least_round_trip_s() for it in self._queues), default=0.0)
            least = _LEAST_SLICE_BYTES if delivered else _MOST_SLICE_BYTES
            most = max(least, delivered * (least_s + _QUEUE_S))
            self._slice_bytes = min(max(least, int(most) // 2), _MOST_SLICE_BYTES)
            return self._granted + waiting < most

    def _delivered(self, acknowledged: int) -> float:
        """Returns the greatest mean rate of the last 200 ms, in B/s, without the rests between."""
        now_s, totals, rates = self._now_s(), self._totals, self._rates
        if now_s - self._asked_s >= _REST_S:
            totals.clear()
        self._asked_s = now_s
        if not totals or now_s - totals[-1][0] >= _INTERVAL_S:
            known = totals[-1][1] if totals else 0
            totals.append((now_s, max(acknowledged, known)))
            while len(totals) > 1 and now_s - totals[1][0] >= _MEAN_S:
                totals.popleft()
            passed_s = now_s - totals[0][0]
            if passed_s >= _REST_S:
                rate = (totals[-1][1] - totals[0][1]) / passed_s
                while rates and rates[-1][1] <= rate:
                    rates.pop()
                rates.append((now_s, rate))
        while rates and now_s - rates[0][0] > _WINDOW_S:
            rates.popleft()
        return rates[0][1] if rates else 0.0
