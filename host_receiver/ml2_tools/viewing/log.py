"""Keeps the newest events of the receiver's topic `log`."""

import threading
from collections import deque

from ml2_receiver.json_text import json_text
from ml2_receiver.printable import printable

LOG = "log"
_MOST_LINES, _MOST_CHARACTERS = 100, 500


class Log:
    """The newest 100 events, each with its time. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._lines: deque[tuple[float, str]] = deque(maxlen=_MOST_LINES)
        self._message: tuple[int, str] = 0, ""

    @property
    def newest(self) -> tuple[int, str]:
        """The number of the newest state, from 1, and its message for browsers; 0 before it."""
        return self._message

    def add(self, unix_s: float, text: str) -> None:
        """Adds an event of a time in s since 1970."""
        with self._lock:
            self._lines.append((unix_s, printable(text, _MOST_CHARACTERS)))
            self._tell()

    def forget(self) -> None:
        """Forgets all events: the next ones may be of an earlier time."""
        with self._lock:
            self._lines.clear()
            self._tell()

    def _tell(self) -> None:
        lines = json_text({"type": LOG, "lines": list(self._lines)})
        self._message = self._message[0] + 1, lines
