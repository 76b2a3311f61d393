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
        publishers = [sink.open(topic) for sink in self._sinks]

        def publish(payload: bytearray) -> None:
            refusal: PublishError | None = None
            for publish_one in publishers:
                try:
                    publish_one(payload)
                except PublishError as error:
                    refusal = error
            if refusal is not None:
                raise refusal

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
