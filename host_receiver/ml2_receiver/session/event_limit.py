"""Bounds what peers can make the receiver say."""

from collections import Counter
from collections.abc import Callable

_MOST_CHARACTERS = 1000
# A day of them, of the most characters, is 24 MB.
_PER_HOUR = 1000
_HOUR_S = 3600.0
_ADDRESSES = 1024


class EventLimit:
    """Passes on so many texts per second and per hour, and tells how many it kept back.

    A text becomes one line that cannot move a terminal's cursor.
    """

    def __init__(
        self,
        say: Callable[[str], None],
        clock: Callable[[], float],
        *,
        per_second: int,
        per_hour: int = _PER_HOUR,
    ) -> None:
        self._say = say
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
            self._say(f"{self._withheld} more such events")
            self._withheld = 0
        if self._second.left and self._hour.left:
            self._second.left -= 1
            self._hour.left -= 1
            text = text[:_MOST_CHARACTERS]
            self._say(text if text.isprintable() else repr(text)[1:-1][:_MOST_CHARACTERS])
            if not self._hour.left:
                self._say("too many events: more are only counted until the hour is over")
        else:
            self._withheld += 1


class _Window:
    """So many are left until so many seconds have passed since the first."""

    def __init__(self, length_s: float, most: int, began_s: float) -> None:
        self._length_s, self._most, self._began_s = length_s, most, began_s
        self.left = most

    def renew(self, now_s: float) -> bool:
        """Whether it has begun anew."""
        if now_s - self._began_s < self._length_s:
            return False
        self._began_s, self.left = now_s, self._most
        return True


class OncePerAddress:
    """Passes on a text once for each address until renew(), which tells how many followed."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._times: Counter[tuple[str, str]] = Counter()

    def say(self, host: str, text: str) -> None:
        if len(self._times) >= _ADDRESSES and (host, text) not in self._times:
            self.renew()
        self._times[host, text] += 1
        if self._times[host, text] == 1:
            self._say(f"{host}: {text}")

    def renew(self) -> None:
        for (host, text), times in self._times.items():
            if times > 1:
                self._say(f"{host}: {text}, {times - 1} more times")
        self._times.clear()
