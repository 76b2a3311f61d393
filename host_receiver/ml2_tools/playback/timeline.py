"""The position in a recording while it is played."""

import threading
from time import monotonic

_NANOS_PER_SECOND = 1_000_000_000


class Timeline:
    """A clock that runs at a rate, can be paused and can jump. Thread-safe.

    After a jump it is stopped until the player has found the position and calls start().

    Args:
        begin_ns: the time of the first message, and the earliest time.
        start_ns: the time to begin at.
        rate: the speed; 2 is twice as fast.
    """

    def __init__(self, begin_ns: int, start_ns: int, rate: float, *, is_paused: bool) -> None:
        self._lock = threading.Lock()
        self._begin_ns, self._rate, self._is_paused = begin_ns, rate, is_paused
        self._start_ns = self._stopped_at_ns = max(begin_ns, start_ns)
        self._running_since_s: float | None = None
        self._jumps = 0

    @property
    def position(self) -> tuple[int, int]:
        """The number of jumps so far, and the target of the last one in ns.

        Messages before the target are not played.
        """
        with self._lock:
            return self._jumps, self._start_ns

    @property
    def is_paused(self) -> bool:
        return self._is_paused

    def now_ns(self) -> int:
        """Returns the current time of the recording."""
        with self._lock:
            return self._now_ns()

    @property
    def offset_s(self) -> float:
        """Seconds since the first message."""
        return (self.now_ns() - self._begin_ns) / _NANOS_PER_SECOND

    def left_s(self, time_ns: int) -> float | None:
        """Returns the time until a message is due, 0 or less if it is; None while stopped."""
        with self._lock:
            if self._running_since_s is None:
                return None
            return (time_ns - self._now_ns()) / _NANOS_PER_SECOND / self._rate

    def start(self, jumps: int) -> None:
        """Starts the clock, unless it is paused or has jumped more than `jumps` times."""
        with self._lock:
            if self._running_since_s is None and not self._is_paused and jumps == self._jumps:
                self._running_since_s = monotonic()

    def toggle(self) -> None:
        """Pauses or resumes."""
        self.pause(not self._is_paused)

    def pause(self, is_paused: bool = True) -> None:
        """Pauses, or resumes."""
        with self._lock:
            self._stop_at(self._now_ns())
            self._is_paused = is_paused

    @property
    def rate(self) -> float:
        """The speed."""
        return self._rate

    def set_rate(self, rate: float) -> None:
        """Goes on at another speed."""
        with self._lock:
            self._stop_at(self._now_ns())
            self._rate = rate

    def hold(self, time_ns: int) -> None:
        """Goes on from a time that the player has not passed; no jump."""
        with self._lock:
            self._stop_at(time_ns)

    def jump(self, time_ns: int) -> None:
        """Jumps to a time of the recording."""
        with self._lock:
            self._start_ns = max(self._begin_ns, time_ns)
            self._stop_at(self._start_ns)
            self._jumps += 1

    def jump_by(self, seconds: float) -> None:
        """Jumps forward, or backward if `seconds` is negative."""
        self.jump(self.now_ns() + round(seconds * _NANOS_PER_SECOND))

    def _stop_at(self, at_ns: int) -> None:
        self._stopped_at_ns, self._running_since_s = at_ns, None

    def _now_ns(self) -> int:
        if self._running_since_s is None:
            return self._stopped_at_ns
        passed_s = (monotonic() - self._running_since_s) * self._rate
        return self._stopped_at_ns + round(passed_s * _NANOS_PER_SECOND)
