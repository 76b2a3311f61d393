"""Messages that were lost before they reached the receiver."""

from collections import Counter
from collections.abc import Iterator

from ..link.report import Report, State
from ..link.statistics import TopicStatistics


class Losses:
    """By topic, since it was made; headsets may come and go meanwhile.

    Args:
        prefix: of the relative topics.
        before: the session there is already, whose losses so far do not count.
    """

    def __init__(self, prefix: str, before: Report | None) -> None:
        self._prefix = prefix
        self._before = {statistics: lost for _, statistics, lost in self._found(before)}
        self._lost: dict[TopicStatistics, tuple[str, int]] = {}

    def update(self, report: Report | None) -> None:
        """Takes what a session has lost up to now."""
        for name, statistics, lost in self._found(report):
            self._lost[statistics] = name, lost - self._before.get(statistics, 0)

    def by_topic(self) -> Counter[str]:
        """Topics that lost nothing are not in it."""
        counts: Counter[str] = Counter()
        for name, lost in list(self._lost.values()):
            if lost:
                counts[name] += lost
        return counts

    def _found(self, report: Report | None) -> Iterator[tuple[str, TopicStatistics, int]]:
        if report is None:
            return
        is_over = report.is_final and report.state is not State.CONNECTED
        for topic in report.topics:
            statistics, lost = topic.statistics, topic.statistics.gaps
            if topic.device is not None and is_over:  # also those after the last that arrived
                lost = topic.device.produced - statistics.received
            yield topic.topic.full_name(self._prefix), statistics, lost
