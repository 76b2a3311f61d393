"""Bounds what peers can make the receiver say."""

from collections.abc import Callable

_MOST_CHARACTERS = 1000


class EventLimit:
    """Passes on so many texts per second, and tells how many it kept back.

    A text becomes one line that cannot move a terminal's cursor.
    """

    def __init__(
        self, say: Callable[[str], None], clock: Callable[[], float], *, per_second: int
    ) -> None:
        self._say = say
        self._per_second = per_second
        self._clock = clock
        self._began_s = clock()
        self._said = self._withheld = 0

    def say(self, text: str) -> None:
        now_s = self._clock()
        if now_s - self._began_s >= 1:
            if self._withheld:
                self._say(f"{self._withheld} more such events")
            self._began_s, self._said, self._withheld = now_s, 0, 0
        if self._said < self._per_second:
            self._said += 1
            text = text[:_MOST_CHARACTERS]
            self._say(text if text.isprintable() else repr(text)[1:-1][:_MOST_CHARACTERS])
        else:
            self._withheld += 1
