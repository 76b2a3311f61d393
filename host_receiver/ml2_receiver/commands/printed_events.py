"""Prints what a ROS log would have."""

import sys

from ..session.report import Report
from ..session.sink import Applied, Publish
from ..table.stream_table import Topic


class PrintedEvents:
    """A Sink that prints events to stderr and nothing else, where no ROS log does."""

    def open(self, topic: Topic) -> Publish:
        return lambda _: None

    def configured(self, applied: Applied) -> None:
        """Its events tell."""

    def event(self, text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    def session_ended(self, report: Report) -> None:
        """Its event tells."""
