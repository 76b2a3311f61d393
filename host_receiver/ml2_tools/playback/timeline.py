"""The time of a recording while it is played."""

import threading
from time import monotonic

_NANOS_PER_SECOND = 1_000_000_000


class Timeline:
    """Passes at a rate, stands still while paused, jumps when told to. Any thread may call it.

    After a jump it stands until the player has found the place and calls go().

    Args:
        begin_ns: the first message's time; nothing is before it.
        start_ns: where to begin.
        rate: 2 is twice as fast.
    """

    def __init__(self, begin_ns: int, start_ns: int, rate: float, *, is_paused: bool) -> None:
        self._lock = threading.Lock()
        self._begin_ns, self._rate, self._is_paused = begin_ns, rate, is_paused
        self._start_ns = self._stands_at_ns = max(begin_ns, start_ns)
        self._passes_since_s: float | None = None
        self._jumps = 0

    @property
    def place(self) -> tuple[int, int]:
        """How often it has jumped, and where to, in ns; earlier messages are not played."""
        with self._lock:
            return self._jumps, self._start_ns

    @property
    def is_paused(self) -> bool:
        return self._is_paused

    def now_ns(self) -> int:
        """The time of the recording that it is now."""
        with self._lock:
            return self._now_ns()

    @property
    def offset_s(self) -> float:
        """Seconds since the first message."""
        return (self.now_ns() - self._begin_ns) / _NANOS_PER_SECOND

    def left_s(self, time_ns: int) -> float | None:
        """How long until a message is due, not above 0 when it is; None while time stands still."""
        with self._lock:
            if self._passes_since_s is None:
                return None
            return (time_ns - self._now_ns()) / _NANOS_PER_SECOND / self._rate

    def go(self, jumps: int) -> None:
        """Lets time pass, unless it is paused, or has jumped more often than this."""
        with self._lock:
            if self._passes_since_s is None and not self._is_paused and jumps == self._jumps:
                self._passes_since_s = monotonic()

    def toggle(self) -> None:
        """Pauses, or goes on."""
        with self._lock:
            self._stand(self._now_ns())
            self._is_paused = not self._is_paused

    def jump(self, time_ns: int) -> None:
        """To another time of the recording."""
        with self._lock:
            self._start_ns = max(self._begin_ns, time_ns)
            self._stand(self._start_ns)
            self._jumps += 1

    def jump_by(self, seconds: float) -> None:
        """To a time that much later, or earlier."""
        self.jump(self.now_ns() + round(seconds * _NANOS_PER_SECOND))

    def _stand(self, at_ns: int) -> None:
        self._stands_at_ns, self._passes_since_s = at_ns, None

    def _now_ns(self) -> int:
        if self._passes_since_s is None:
            return self._stands_at_ns
        passed_s = (monotonic() - self._passes_since_s) * self._rate
        return self._stands_at_ns + round(passed_s * _NANOS_PER_SECOND)
