"""The subscriptions of apps, which are as their publishers need them."""

from collections import deque
from collections.abc import Mapping

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from ..session.subscription_queue import Payload, SubscriptionQueue
from .layout import Described, plain

_LEAST_DEPTH = 10
# Messages to recognise: a subscription that replaces another one may get them again.
_REMEMBERED = 1000


class Heard:
    """The messages taken of a topic: drops those that come again, and counts those that ROS lost.

    Only the takers' threads use it, but for `publishers`, the identities of those there are.
    """

    def __init__(self) -> None:
        self.publishers: tuple[bytes, ...] = ()
        self._recent: deque[tuple[int, int]] = deque()
        self._known: set[tuple[int, int]] = set()
        self._last: tuple[tuple[bytes, ...], int] | None = None

    def is_new(self, message: tuple[int, int]) -> bool:
        """Returns False for a source time and number that was taken, by an earlier subscription."""
        if message in self._known:
            return False
        if len(self._recent) == _REMEMBERED:
            self._known.remove(self._recent.popleft())
        self._recent.append(message)
        self._known.add(message)
        return True

    def missed(self, number: int) -> int:
        """Returns how many messages ROS lost before this one.

        Numbers count the messages of a publisher, so they tell nothing while there are several.
        """
        publishers, last = self.publishers, self._last
        self._last = publishers, number
        if len(publishers) != 1 or last is None or last[0] != publishers:
            return 0
        return max(0, number - last[1] - 1)


class AppSubscription:
    """One subscription of rclpy for a queue; another one follows when publishers change."""

    def __init__(
        self, queue: SubscriptionQueue, own: Described, qos: QoSProfile, heard: Heard
    ) -> None:
        self.type, self.topic, self.qos = queue.type, queue.name, qos
        self.queue, self.own, self.heard = queue, own, heard

    def take(self, payload: bytes, info: Mapping[str, int]) -> None:
        times = info["source_timestamp"], info["publication_sequence_number"]
        self.take_plain(plain(payload, self.own.layout), *times)

    def take_plain(self, payload: Payload, source_ns: int, number: int) -> None:
        if self.heard.is_new((source_ns, number)):
            if (missed := self.heard.missed(number)) > 0:
                self.queue.miss(missed)
            self.queue.put(payload, source_ns)


def identities(publishers: list[TopicEndpointInfo]) -> tuple[bytes, ...]:
    """Returns who publishes a topic."""
    return tuple(sorted(bytes(it.endpoint_gid) for it in publishers))


def qos_of(publishers: list[TopicEndpointInfo], depth: int) -> QoSProfile:
    """Returns what all publishers can serve; who serves less is not heard."""
    of_all = [it.qos_profile for it in publishers]
    is_reliable = all(it.reliability == ReliabilityPolicy.RELIABLE for it in of_all)
    is_latched = all(it.durability == DurabilityPolicy.TRANSIENT_LOCAL for it in of_all)
    return QoSProfile(
        depth=max(depth, _LEAST_DEPTH),
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if of_all and is_latched
        else DurabilityPolicy.VOLATILE,
    )


def is_latched(qos: QoSProfile) -> bool:
    """Returns True if messages from before come, too."""
    return bool(qos.durability == DurabilityPolicy.TRANSIENT_LOCAL)


def other_type(own: Described, publishers: list[TopicEndpointInfo]) -> str | None:
    """Returns what is wrong if a publisher has another type, or another version of it."""
    for it in publishers:
        node = f"{it.node_namespace.rstrip('/')}/{it.node_name}"
        if it.topic_type != own.type:
            return f"{node} publishes {it.topic_type}, and the app wants {own.type}"
        hash = str(it.topic_type_hash)
        if own.hash and hash.startswith("RIHS01_") and hash != own.hash:
            return f"{node} publishes {own.type} of {hash}, and this receiver has {own.hash}"
    return None
