"""Counts losses by reason."""

from collections import Counter

from ml2_receiver.printable import printable

_MOST_REASONS = 100
_MOST_CHARACTERS = 200


class Losses:
    """Counts by reason, with a bounded number of reasons: some quote data from the network."""

    OTHER = "other reasons"

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()

    def add(self, reason: str) -> None:
        """Counts one more loss for this reason."""
        reason = printable(reason, _MOST_CHARACTERS)
        is_known = reason in self._counts or len(self._counts) < _MOST_REASONS
        self._counts[reason if is_known else self.OTHER] += 1

    def counts(self) -> dict[str, int]:
        """Returns the counts by reason, the most frequent first."""
        return dict(self._counts.most_common())
