"""The sink that publishes on Zenoh."""

import threading
from collections import defaultdict
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace

import zenoh

from ..errors import PublishError
from ..session.report import Report
from ..session.sink import Applied, Publish
from ..table.stream_table import Qos, StreamTable, Topic
from ..topics.config_topic import config_text
from ..topics.plain_messages import encode_string
from .names import NODE_NAME, Node, TopicName
from .publisher import ZenohPublisher

_DIAGNOSTICS = TopicName("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", Qos(10))


class ZenohSink:
    """A Sink that publishes in a session of Zenoh; the topics `config` and `log` too. Thread-safe.

    Args:
        session: stays open until after close().
        prefix: of the relative topics.
        receiver: as in --name, may be empty.
        domain: the ROS domain id.
        demand_changed: called when topics have come or gone, and by a thread of Zenoh when a
            topic's first subscriber has come, or its last one gone; returns at once.
        remapped: returns the name of a topic after the remappings of ROS's arguments.
        node: its name after them.

    Raises:
        PublishError: Zenoh does not take the names.
    """

    def __init__(
        self,
        session: zenoh.Session,
        table: StreamTable,
        prefix: str,
        receiver: str,
        domain: int,
        demand_changed: Callable[[], None],
        remapped: Callable[[str], str] = str,
        node: str = NODE_NAME,
    ) -> None:
        self._session, self._table, self._prefix = session, table, prefix
        self._demand_changed = demand_changed
        self._remapped = remapped
        self._node = Node(domain, str(session.zid()), receiver, node)
        self._token = session.liveliness().declare_token(self._node.token())
        self._lock = threading.Lock()
        self._count = 0
        self._publishers: dict[Topic, ZenohPublisher] = {}
        self._own = {
            topic.name: self._publisher(
                TopicName(f"{prefix}/{topic.name}", topic.type, table.qos[topic.qos])
            )
            for topic in table.receiver_topics
        }
        self._diagnostics = self._publisher(_DIAGNOSTICS)

    def open(self, topic: Topic) -> Publish:
        with self._lock:
            if topic not in self._publishers:
                name = topic.full_name(self._prefix)
                self._publishers[topic] = self._publisher(
                    TopicName(name, topic.type, self._table.qos[topic.qos]),
                    is_urgent=topic.lane.is_urgent,
                )
                self._demand_changed()
            return self._publishers[topic].publish

    def configured(self, applied: Applied) -> None:
        with self._lock:
            for topic in self._publishers.keys() - set(applied.topics):
                self._publishers.pop(topic).close()
        self._demand_changed()
        self._say("config", config_text(applied, self._prefix))

    def event(self, text: str) -> None:
        self._say("log", text)

    def session_ended(self, report: Report) -> None:
        """The next /diagnostics tells."""

    def diagnose(self, payload: bytes) -> None:
        """Publishes a payload on /diagnostics.

        Raises:
            PublishError: Zenoh does not take it.
        """
        self._diagnostics.publish(payload)

    def published(self) -> Mapping[str, int]:
        """Returns how many messages Zenoh took of each topic of the headset, by its full name."""
        with self._lock:
            return {t.full_name(self._prefix): it.published for t, it in self._publishers.items()}

    def demand(self) -> Mapping[str, bool]:
        """Returns for each stream with topics whether one of them has a subscriber."""
        demand: defaultdict[str, bool] = defaultdict(bool)
        with self._lock:
            for topic, publisher in self._publishers.items():
                demand[topic.stream] |= publisher.has_subscriber
        return demand

    def close(self) -> None:
        """Ends all topics and the node; nothing may be called after."""
        with self._lock:
            for publisher in (*self._publishers.values(), *self._own.values(), self._diagnostics):
                publisher.close()
            self._token.undeclare()

    def _publisher(self, topic: TopicName, *, is_urgent: bool = True) -> ZenohPublisher:
        self._count += 1
        topic = replace(topic, name=self._remapped(topic.name))
        priority = zenoh.Priority.REAL_TIME if is_urgent else zenoh.Priority.DATA_LOW
        return ZenohPublisher(
            self._session, self._node, self._count, topic, priority, self._demand_changed
        )

    def _say(self, name: str, text: str) -> None:
        with suppress(PublishError):  # the session has ended, which its own event says
            self._own[name].publish(encode_string(text))
