"""Finds messages that several files of a recording have."""

from collections import Counter
from collections.abc import Hashable


class Copies:
    """Tells which messages to leave out, so that those that several files have come once.

    A recovered file beside its original has the same messages, but may lack the first or the last
    ones. Equal messages of one file are no copies.

    Attributes:
        count: the number of copies so far.
    """

    def __init__(self) -> None:
        self.count = 0
        self._seen: dict[Hashable, Counter[int]] = {}
        self._time_ns: int | None = None

    def at(self, time_ns: int) -> None:
        """Forgets all messages of other times."""
        if time_ns != self._time_ns:
            self._time_ns = time_ns
            self._seen.clear()

    def is_copy(self, file: int, message: Hashable) -> bool:
        """Takes a message of a file; returns True if another file had it before."""
        by_file = self._seen.setdefault(message, Counter())
        by_file[file] += 1
        is_copy = any(count >= by_file[file] for it, count in by_file.items() if it != file)
        self.count += is_copy
        return is_copy
