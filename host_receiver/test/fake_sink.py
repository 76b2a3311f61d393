"""A Sink in memory, strict about its contract."""

import threading
from collections import defaultdict

from ml2_receiver.configuration.app_rules import AppRules
from ml2_receiver.errors import PublishError
from ml2_receiver.session.downlink import Downlink
from ml2_receiver.session.report import Report
from ml2_receiver.session.sink import Applied, Publish
from ml2_receiver.session.subscription_queue import SubscriptionQueue
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.frame import Frame
from ml2_receiver.wire.opening_bodies import Open, Opened
from waiting import LIMIT_S

_NOTHING = AppRules()


class FakeSink:
    """Keeps everything; `refuses` has the topics whose messages it does not take, `unmakeable` the
    types it cannot make topics of.
    """

    def __init__(self) -> None:
        self.payloads: dict[str, list[bytes]] = defaultdict(list)
        self.opened: list[Topic] = []
        self.applied: list[Applied] = []
        self.events: list[str] = []
        self.reports: list[Report] = []
        self.refuses: set[str] = set()
        self.unmakeable: set[str] = set()
        self._changed = threading.Condition()

    def open(self, topic: Topic) -> Publish:
        if topic.type in self.unmakeable:
            raise PublishError(f"there is no {topic.type}")
        self.opened.append(topic)

        def publish(payload: bytearray) -> None:
            assert type(payload) is bytearray
            if topic.name in self.refuses:
                raise PublishError("refused")
            with self._changed:
                self.payloads[topic.name].append(bytes(payload))
                self._changed.notify_all()

        return publish

    def configured(self, applied: Applied) -> None:
        self._add(self.applied, applied)

    def event(self, text: str) -> None:
        self._add(self.events, text)

    def session_ended(self, report: Report) -> None:
        self._add(self.reports, report)

    def _add[T](self, to: list[T], item: T) -> None:
        with self._changed:
            to.append(item)
            self._changed.notify_all()

    def await_payloads(self, topic: str, count: int) -> list[bytes]:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.payloads[topic]) >= count, LIMIT_S)
            return self.payloads[topic]

    def await_event(self, text: str) -> None:
        with self._changed:
            assert self._changed.wait_for(
                lambda: any(text in event for event in self.events), LIMIT_S
            ), self.events

    def await_report(self) -> Report:
        with self._changed:
            assert self._changed.wait_for(lambda: self.reports, LIMIT_S)
            return self.reports[-1]


class FakeGraph:
    """Opens every name, and keeps what comes; `bulk` decides the lane.

    `queues` has the subscriptions by id, `remapped` the names that have another one.
    """

    def __init__(self, rules: AppRules = _NOTHING) -> None:
        self.rules = rules
        self.remapped: dict[str, str] = {}
        self.closed: list[int] = []
        self.received_numbers: list[tuple[int, int]] = []
        self.queues: dict[int, SubscriptionQueue] = {}

    def resolve(self, wanted: Open) -> str:
        name = wanted.name or ""
        if " " in name:
            raise ValueError(f"{name!r} is no name")
        return self.remapped.get(name, name)

    def open(self, wanted: Open, name: str, downlink: Downlink) -> Opened:
        if wanted.kind != "subscription":
            return Opened(wanted.id, "opened", name=name, lane="ros")
        queue = downlink.queue(wanted, name, is_bulk=bool(wanted.bulk))
        self.queues[wanted.id] = queue
        return Opened(wanted.id, "opened", name=name, lane=queue.lane.name)

    def close(self, id: int) -> None:
        self.closed.append(id)

    def received(self, frame: Frame) -> None:
        self.received_numbers.append((frame.header.channel, frame.header.sequence))
