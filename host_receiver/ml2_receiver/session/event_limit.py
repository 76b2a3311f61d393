"""Rate limits for the log lines that peers can cause."""

import sys
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Literal

from ..printable import printable

_MAX_CHARACTERS = 1000
# At most 24 MB a day.
_PER_HOUR = 1000
_HOUR_S = 3600.0
_ADDRESSES = 1024

type Cause = Literal["session", "refusal", "turned away", "receiver"]
_PER_SECOND: Mapping[Cause, int] = {"session": 100, "refusal": 10, "turned away": 1, "receiver": 1}


class EventLimit:
    """A rate limit for log lines, which also logs how many lines it withheld.

    Each text becomes one line of printable characters, so it cannot move a terminal's cursor.
    """

    def __init__(
        self,
        log_line: Callable[[str], None],
        clock: Callable[[], float],
        *,
        per_second: int,
        per_hour: int = _PER_HOUR,
    ) -> None:
        self._log_line = log_line
        self._clock = clock
        self._second = _Window(1.0, per_second, clock())
        self._hour = _Window(_HOUR_S, per_hour, clock())
        self._withheld = 0

    def say(self, text: str) -> None:
        now_s = self._clock()
        is_new_second = self._second.renew(now_s)
        self._hour.renew(now_s)
        if is_new_second and self._withheld and self._hour.left:
            self._hour.left -= 1
            self._log_line(f"{self._withheld} more such events")
            self._withheld = 0
        if self._second.left and self._hour.left:
            self._second.left -= 1
            self._hour.left -= 1
            self._log_line(printable(text, _MAX_CHARACTERS))
            if not self._hour.left:
                self._log_line("too many events: more are only counted until the hour is over")
        else:
            self._withheld += 1


class _Window:
    """A period of time, and the number of lines that are left in it."""

    def __init__(self, length_s: float, limit: int, start_s: float) -> None:
        self._length_s, self._limit, self._start_s = length_s, limit, start_s
        self.left = limit

    def renew(self, now_s: float) -> bool:
        """Starts the next window and returns True if this one has passed."""
        if now_s - self._start_s < self._length_s:
            return False
        self._start_s, self.left = now_s, self._limit
        return True


def event_limits(
    log_line: Callable[[str], None], clock: Callable[[], float]
) -> dict[Cause, EventLimit]:
    """Returns the limit for the lines of each cause; lines for which log_line fails are printed."""

    def log(text: str) -> None:
        try:
            log_line(text)
        except Exception:  # it may be the failure of `log_line` that is logged
            print(text, file=sys.stderr, flush=True)

    return {it: EventLimit(log, clock, per_second=n) for it, n in _PER_SECOND.items()}


class OncePerAddress:
    """A filter that logs each text once per address until renew()."""

    def __init__(self, log_line: Callable[[str], None]) -> None:
        self._log_line = log_line
        self._times: Counter[tuple[str, str]] = Counter()

    def say(self, host: str, text: str) -> None:
        if len(self._times) >= _ADDRESSES and (host, text) not in self._times:
            self.renew()
        self._times[host, text] += 1
        if self._times[host, text] == 1:
            self._log_line(f"{host}: {text}")

    def renew(self) -> None:
        """Logs how often each text was repeated, and starts over."""
        for (host, text), times in self._times.items():
            if times > 1:
                self._log_line(f"{host}: {text}, {times - 1} more times")
        self._times.clear()
