"""Counts messages and requests that a thread left out because they raised an error."""

import sys
import threading
from collections import Counter
from collections.abc import Mapping

from ml2_receiver.printable import printable

_MOST_REASONS = 100
_MOST_CHARACTERS = 300


class Faults:
    """Counts what was left out by reason, and says each reason once on stderr. Thread-safe."""

    OTHER = "for other reasons"

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: Counter[str] = Counter()

    def add(self, what: str, error: Exception) -> None:
        """Counts what an error has left out; `what` names it, such as a message of a topic."""
        reason = printable(f"{what}: {type(error).__name__}: {error}", _MOST_CHARACTERS)
        with self._lock:
            if reason not in self._counts and len(self._counts) >= _MOST_REASONS:
                reason = self.OTHER
            self._counts[reason] += 1
            is_new = self._counts[reason] == 1
        if is_new:
            print(f"left out: {reason}", file=sys.stderr, flush=True)

    def counts(self) -> Mapping[str, int]:
        """Returns how much was left out so far by reason, the most frequent first."""
        with self._lock:
            return dict(self._counts.most_common())
