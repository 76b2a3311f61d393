"""Tells events on a terminal where no ROS log does."""

import sys

from ..configuration.table import Topic
from ..link.report import Report
from ..topics.sink import Applied, Publish


class PrintedEvents:
    """A Sink that prints events to stderr and nothing else."""

    def open(self, topic: Topic) -> Publish:
        return lambda _: None

    def configured(self, applied: Applied) -> None:
        """Its events tell."""

    def event(self, text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    def session_ended(self, report: Report) -> None:
        """Its event tells."""
