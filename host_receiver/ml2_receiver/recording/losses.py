"""Messages that were lost before they reached the receiver."""

import threading
from collections import Counter
from collections.abc import Iterator

from ..session.report import Report, State
from ..session.statistics import TopicStatistics


class Losses:
    """Counts lost messages by topic since it was constructed, over all sessions. Thread-safe.

    Args:
        prefix: the prefix of the relative topics.
        before: the report of the current session, whose earlier losses do not count.
    """

    def __init__(self, prefix: str, before: Report | None) -> None:
        self._prefix = prefix
        self._lock = threading.Lock()
        self._lost: Counter[str] = Counter()
        self._known = {name: (counts, lost) for name, counts, lost in self._found(before)}

    def update(self, report: Report | None) -> None:
        """Takes the losses of a session up to now."""
        with self._lock:
            for name, statistics, lost in self._found(report):
                known, before = self._known.get(name, (statistics, 0))
                self._lost[name] += lost - (before if known is statistics else 0)
                self._known[name] = statistics, lost

    def by_topic(self) -> dict[str, int]:
        """Returns the lost messages by topic, without topics that lost none."""
        with self._lock:
            return {name: lost for name, lost in self._lost.items() if lost}

    def _found(self, report: Report | None) -> Iterator[tuple[str, TopicStatistics, int]]:
        if report is None:
            return
        is_over = report.is_final and report.state is not State.CONNECTED
        for topic in report.topics:
            statistics, lost = topic.statistics, topic.statistics.gaps
            if topic.device is not None and is_over:  # also those after the last that arrived
                lost = topic.device.produced - statistics.received
            yield topic.topic.full_name(self._prefix), statistics, lost
