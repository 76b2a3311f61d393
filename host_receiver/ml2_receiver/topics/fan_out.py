"""Several sinks as one."""

import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from ..errors import PublishError
from ..session.report import Report
from ..session.sink import Applied, Publish, Sink
from ..table.reader import load_table
from ..table.stream_table import Topic


@dataclass
class _Outlet:
    """The publishers of a topic; `kept` has the payloads for sinks that are added later."""

    publishers: tuple[tuple[Sink, Publish], ...]
    kept: deque[bytes] = field(default_factory=deque)


class FanOut:
    """A Sink that calls other sinks, in their order; sinks may be added and removed. Thread-safe.

    A sink that is added later gets the open topics, the last configuration, and the last payloads
    of latched topics.
    """

    def __init__(self, sinks: Sequence[Sink]) -> None:
        self._sinks = list(sinks)
        self._lock = threading.RLock()
        self._outlets: dict[Topic, _Outlet] = {}
        self._applied: Applied | None = None

    def add(self, sink: Sink) -> None:
        """Adds a sink."""
        with self._lock:
            self._sinks.append(sink)
            for topic, outlet in self._outlets.items():
                outlet.publishers += tuple(self._opened(topic, [sink]))
            if self._applied is not None:
                sink.configured(self._applied)
            for outlet in self._outlets.values():
                for payload in outlet.kept:
                    _publish(bytearray(payload), [it for it in outlet.publishers if it[0] is sink])

    def remove(self, sink: Sink) -> None:
        """Removes a sink; a payload may still be in transit to it."""
        with self._lock:
            self._sinks.remove(sink)
            for outlet in self._outlets.values():
                outlet.publishers = tuple(it for it in outlet.publishers if it[0] is not sink)

    def open(self, topic: Topic) -> Publish:
        """Opens the topic on each sink that can; events say why others cannot."""
        qos = load_table().qos[topic.qos]
        with self._lock:
            publishers = tuple(self._opened(topic, self._sinks))
            outlet = self._outlets.setdefault(topic, _Outlet((), deque(maxlen=qos.depth)))
            outlet.publishers = publishers

        def publish(payload: bytearray) -> None:
            _publish(payload, outlet.publishers)

        def publish_latched(payload: bytearray) -> None:
            with self._lock:  # So that a sink that is being added gets it once
                outlet.kept.append(bytes(payload))
                _publish(payload, outlet.publishers)

        return publish_latched if qos.durability == "transient_local" else publish

    def configured(self, applied: Applied) -> None:
        with self._lock:
            self._applied = applied
            for topic in self._outlets.keys() - set(applied.topics):
                del self._outlets[topic]
            for sink in self._sinks:
                sink.configured(applied)

    def event(self, text: str) -> None:
        with self._lock:
            for sink in self._sinks:
                sink.event(text)

    def session_ended(self, report: Report) -> None:
        with self._lock:
            for sink in self._sinks:
                sink.session_ended(report)

    def _opened(self, topic: Topic, sinks: Sequence[Sink]) -> list[tuple[Sink, Publish]]:
        publishers: list[tuple[Sink, Publish]] = []
        refusals: list[PublishError] = []
        for sink in sinks:
            try:
                publishers.append((sink, sink.open(topic)))
            except PublishError as error:
                refusals.append(error)
        if refusals and len(refusals) == len(self._sinks):
            raise refusals[0]
        for refusal in refusals:
            self.event(str(refusal))
        return publishers


def _publish(payload: bytearray, publishers: Sequence[tuple[Sink, Publish]]) -> None:
    last: PublishError | None = None
    for _, publish in publishers:
        try:
            publish(payload)
        except PublishError as error:
            last = error
    if last is not None:
        raise last
