"""What could not be made of what arrived, and why."""

from __future__ import annotations

from collections import Counter

_MOST_REASONS = 100
_MOST_CHARACTERS = 200


class Losses:
    """Counts by reason; bounded, for some reasons quote what came over the network."""

    OTHER = "other reasons"

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()

    def add(self, reason: str) -> None:
        """One more for this reason."""
        reason = reason[:_MOST_CHARACTERS]
        is_known = reason in self._counts or len(self._counts) < _MOST_REASONS
        self._counts[reason if is_known else self.OTHER] += 1

    def counts(self) -> dict[str, int]:
        """By reason, the most frequent first."""
        return dict(self._counts.most_common())
