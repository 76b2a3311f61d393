"""Several sinks as one."""

from collections.abc import Sequence

from ..configuration.table import Topic
from ..errors import PublishError
from ..link.report import Report
from .sink import Applied, Publish, Sink


class FanOut:
    """A Sink that tells all others, in their order."""

    def __init__(self, sinks: Sequence[Sink]) -> None:
        self._sinks = sinks

    def open(self, topic: Topic) -> Publish:
        """As far as some sink can make the topic; events say why others cannot."""
        publishers: list[Publish] = []
        refusals: list[PublishError] = []
        for sink in self._sinks:
            try:
                publishers.append(sink.open(topic))
            except PublishError as error:
                refusals.append(error)
        if not publishers:
            raise refusals[0]
        for refusal in refusals:
            self.event(str(refusal))

        def publish(payload: bytearray) -> None:
            last: PublishError | None = None
            for publish_one in publishers:
                try:
                    publish_one(payload)
                except PublishError as error:
                    last = error
            if last is not None:
                raise last

        return publish

    def configured(self, applied: Applied) -> None:
        for sink in self._sinks:
            sink.configured(applied)

    def event(self, text: str) -> None:
        for sink in self._sinks:
            sink.event(text)

    def session_ended(self, report: Report) -> None:
        for sink in self._sinks:
            sink.session_ended(report)
