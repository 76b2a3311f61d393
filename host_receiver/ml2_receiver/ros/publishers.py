"""The publishers of the headset's topics."""

import threading
from collections import defaultdict
from collections.abc import Callable, Collection, Mapping

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from ..errors import PublishError
from ..session.sink import Publish
from ..table.stream_table import Qos, StreamTable, Topic
from ..topics.message_types import message_class
from .qos_overrides import OVERRIDABLE
from .raw_publish import raw_publish


class Publishers:
    """One per topic, from open() until keep_only() without it. Thread-safe.

    Args:
        takes_bytearray: see raw_publish().
        demand: is told, when topics or subscribers have come or gone, which streams have topics,
            each with whether one of them has a subscriber.
    """

    def __init__(
        self,
        node: Node,
        table: StreamTable,
        prefix: str,
        *,
        takes_bytearray: bool,
        demand: Callable[[Mapping[str, bool]], None],
    ) -> None:
        self._node, self._table, self._prefix = node, table, prefix
        self._takes_bytearray, self._demand = takes_bytearray, demand
        self._lock = threading.Lock()
        self._publishers: dict[Topic, Publisher] = {}

    def open(self, topic: Topic) -> Publish:
        """Returns a function that publishes payloads on the topic.

        Raises:
            PublishError: its type is not installed, or QoS overrides of the user are wrong.
        """
        with self._lock:
            if topic not in self._publishers:
                name = topic.full_name(self._prefix)
                qos = self._table.qos[topic.qos]
                try:
                    publisher = create_publisher(self._node, name, topic.type, qos, self._tell)
                except (ImportError, ParameterException, RuntimeError) as error:
                    raise PublishError(f"{name} is not published: {error}") from error
                self._publishers[topic] = publisher
            publish = raw_publish(self._publishers[topic], self._takes_bytearray)
        self._tell()
        return publish

    def keep_only(self, topics: Collection[Topic]) -> None:
        """Ends all other topics."""
        with self._lock:
            for topic in self._publishers.keys() - set(topics):
                self._node.destroy_publisher(self._publishers.pop(topic))
        self._tell()

    def subscribers(self) -> dict[Topic, int]:
        """Returns the number of subscribers of each topic."""
        with self._lock:
            return self._subscribers()

    def _subscribers(self) -> dict[Topic, int]:
        return {topic: it.get_subscription_count() for topic, it in self._publishers.items()}

    def _tell(self) -> None:
        needed: defaultdict[str, bool] = defaultdict(bool)
        with self._lock:  # so that the last to count is the last to tell
            for topic, count in self._subscribers().items():
                needed[topic.stream] |= count > 0
            self._demand(needed)


def create_publisher(
    node: Node, name: str, type: str, qos: Qos, demand_changed: Callable[[], None] | None = None
) -> Publisher:
    """RELIABLE and KEEP_LAST, unless the user's qos_overrides parameters say otherwise."""
    return node.create_publisher(
        message_class(type),
        name,
        QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=qos.depth,
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy[qos.durability.upper()],
        ),
        event_callbacks=PublisherEventCallbacks(
            matched=demand_changed and (lambda _: demand_changed())
        ),
        qos_overriding_options=OVERRIDABLE,
    )
