"""Bounds what large messages to the headset have under way; ARCHITECTURE.md, Pacing."""

import threading
import time
from collections import deque
from collections.abc import Callable
from math import inf
from typing import Protocol

# The shortest wait for acknowledgements, and the longest wait for anything. Each thread that wakes
# takes the interpreter from those that publish samples.
_POLL_S, _MOST_WAIT_S = 0.0005, 0.002
# The queue that large messages may have in the link: images of the headset, whose acknowledgements
# come back behind them, take 6 ms for a queue of their own. TCP acknowledges every second segment,
# and a single one 40 ms late. So a slow link needs more, almost two jumbo segments.
_QUEUE_S, _LEAST_QUEUE_BYTES = 0.003, 16 << 10
_LEAST_SLICE_BYTES, _MOST_SLICE_BYTES, _SLICE_S = 4 << 10, 16 << 10, 0.001
# Acknowledgements that arrive together would else be followed by a burst as long as the path. What
# a thread that woke late has missed may be written at once.
_SPACING_GAIN, _BURST_S = 1.25, 0.003
# Images come in bursts, 30 times a second: a shorter time has none, in which the link seems free.
_MEAN_S = 0.07
_WINDOW_S, _INTERVAL_S, _REST_S, _LONG_REST_S = 0.2, 0.002, 0.02, 1.0
_ROUND_TRIP_S = 0.1
# If both directions share a link, some of the uplink's queue is that of large messages.
_UPLINK_PART, _MOST_UPLINK_S, _UPLINK_WEIGHT, _LEAST_OF_S = 0.8, 0.02, 0.25, 5.0


class PacedConnection(Protocol):
    """A connection that carries large messages."""

    def send_all(self, data: bytes | memoryview) -> None:
        """Hands all of `data` to the kernel."""

    def unacknowledged(self) -> int:
        """Returns the bytes that the peer has not acknowledged; 0 when it is closed."""

    def least_round_trip_s(self) -> float:
        """Returns the least round trip of the connection."""


class Pacing:
    """Lets the lanes of one session write in slices. Thread-safe.

    Slices are spaced at 1.25 times the rate that the link delivers. The bytes under way are at most
    what the link delivers in its least round trip, and a queue of 3 ms or 16 KiB. Four fifths of
    the time that requests wait on the uplink are added, since acknowledgements wait there as well.
    So the rate grows until the link has a short queue. Images that share the link, as in the air
    of Wi-Fi, lower what is delivered, and with it the rate.

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
        self._sending: set[PacedConnection] = set()  # those with bytes under way
        self._least_round_trip_s, self._round_trip_known_s = 0.0, -inf
        self._granted = self._written = 0
        self._slice_bytes = _LEAST_SLICE_BYTES
        self._rate = 0.0  # in B/s; 0 before it is known
        self._next_s = self._asked_s = now_s()
        self._rested_s = 0.0
        self._uplink = _UplinkDelay()
        # Times in s, with the bytes acknowledged by then, and with rates that none later exceeds
        self._totals: deque[tuple[float, int]] = deque()
        self._rates: deque[tuple[float, float]] = deque()

    def send(self, data: bytes | memoryview, connection: PacedConnection) -> None:
        """Sends data in slices."""
        view = memoryview(data)
        while view:
            piece = view[: self._slice_bytes]
            self._wait(len(piece))
            try:
                connection.send_all(piece)
            finally:
                with self._lock:
                    self._granted -= len(piece)
                    self._written += len(piece)
                    self._sending.add(connection)
            view = view[len(piece) :]

    def _wait(self, length: int) -> None:
        """Waits until a slice may be written."""
        with self._turn:
            while (wait_s := self._wait_s(length)) > 0 and not self._is_over():
                self._sleep(wait_s)
            with self._lock:
                self._granted += length
                if self._rate:
                    from_s = max(self._next_s, self._now_s() - _BURST_S)
                    self._next_s = from_s + length / (_SPACING_GAIN * self._rate)

    def requested(self, way_s: float) -> None:
        """Takes the time of a request's way from the headset, off by a constant."""
        with self._lock:
            self._uplink.add(way_s, self._now_s())

    def _wait_s(self, length: int) -> float:
        with self._lock:
            waiting = self._under_way()
            self._rate = self._delivered(self._written - waiting)
            path_s = self._least_round_trip_s
            path_s += _UPLINK_PART * min(self._uplink.mean_s, _MOST_UPLINK_S)
            most = self._rate * path_s + max(_LEAST_QUEUE_BYTES, self._rate * _QUEUE_S)
            slice_bytes = max(_LEAST_SLICE_BYTES, int(self._rate * _SLICE_S))
            self._slice_bytes = min(slice_bytes, _MOST_SLICE_BYTES)
            excess_bytes = self._granted + waiting + length - most
            if excess_bytes > 0:
                wait_s = excess_bytes / self._rate if self._rate else _POLL_S
                return min(max(wait_s, _POLL_S), _MOST_WAIT_S)
            return min(self._next_s - self._now_s(), _MOST_WAIT_S)

    def _under_way(self) -> int:
        """Returns the bytes under way, and notes the least round trip from time to time."""
        waiting = 0
        for connection in list(self._sending):
            unacknowledged = connection.unacknowledged()
            waiting += unacknowledged
            if not unacknowledged:
                self._sending.discard(connection)
        now_s = self._now_s()
        if self._sending and now_s - self._round_trip_known_s > _ROUND_TRIP_S:
            round_trips_s = [it.least_round_trip_s() for it in self._sending]
            self._least_round_trip_s, self._round_trip_known_s = min(round_trips_s), now_s
        return waiting

    def _delivered(self, acknowledged: int) -> float:
        """Returns the greatest mean rate of the last 200 ms of sending, in B/s."""
        now_s, totals, rates = self._now_s(), self._totals, self._rates
        rest_s, self._asked_s = now_s - self._asked_s, now_s
        if rest_s >= _REST_S:
            totals.clear()
            if rest_s < _LONG_REST_S:
                self._rested_s += rest_s
        now_s -= self._rested_s
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


class _UplinkDelay:
    """The mean time that requests have waited on their way, over the least of 5 to 10 s."""

    def __init__(self) -> None:
        self.mean_s = 0.0
        self._leasts_s = inf, inf
        self._since_s = -inf

    def add(self, way_s: float, now_s: float) -> None:
        older_s, recent_s = self._leasts_s
        if now_s - self._since_s > _LEAST_OF_S:
            older_s, recent_s, self._since_s = recent_s, way_s, now_s
        self._leasts_s = older_s, min(recent_s, way_s)
        waited_s = way_s - min(self._leasts_s)
        self.mean_s += _UPLINK_WEIGHT * (waited_s - self.mean_s)
