"""Carries out the openings of apps with ROS: subscriptions, clients of services, transforms."""

import threading
from collections import deque
from collections.abc import Mapping
from typing import Self

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rclpy.validate_full_topic_name import validate_full_topic_name

from ..configuration.app_rules import AppRules
from ..session.downlink import Downlink
from ..session.graph import refused
from ..session.subscription_queue import Payload, SubscriptionQueue
from ..wire.frame import Frame
from ..wire.kinds import ROS
from ..wire.opening_bodies import Open, Opened
from .app_clients import AppClient
from .app_transforms import AppTransforms
from .bulk_process import BulkTaker
from .layout import Described, DifferentError, described, described_service, plain
from .node import RosNode
from .raw_taker import RawTaker
from .real_time import steady_timer

_FOLLOW_S = 0.5
_LONGEST_NAME = 255
_LEAST_DEPTH = 10
# What a subscription that replaces another one may get again.
_REMEMBERED = 1000
_OF_SERVICES = ("client", "service")


class Heard:
    """What was taken of a topic: nothing is delivered twice, and what ROS lost is counted.

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


class _Subscription:
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


class RosGraph:
    """A Graph whose subscriptions are those of a node of its own, `ml2_receiver_openings`.

    Use it as a context manager. Thread-safe.

    Args:
        node: that of the receiver, whose names and remappings hold for apps, too.
    """

    def __init__(self, node: RosNode) -> None:
        self._ros = node
        self._lock = threading.Lock()
        self._node: Node | None = None
        self._taker: RawTaker | None = None
        self._bulk_taker: BulkTaker | None = None
        self._open: dict[int, _Subscription] = {}
        self._clients: dict[int, AppClient] = {}
        self._transforms = AppTransforms(node.remapped)
        steady_timer(node.parameters, _FOLLOW_S, self._follow)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bulk_taker is not None:
            self._bulk_taker.stop()
        if self._taker is not None and self._node is not None:
            self._taker.stop()
            self._node.destroy_node()

    @property
    def rules(self) -> AppRules:
        return self._ros.config.app

    def resolve(self, wanted: Open) -> str:
        try:
            name = self._ros.remapped(wanted.name or "", is_service=wanted.kind in _OF_SERVICES)
            validate_full_topic_name(name)
        except Exception as error:  # of several types
            raise ValueError(f"{wanted.name!r} is no name of ROS: {error}") from error
        if len(name) > _LONGEST_NAME:
            raise ValueError(f"{name!r} has more than {_LONGEST_NAME} characters")
        return name

    def open(self, wanted: Open, name: str, downlink: Downlink) -> Opened:
        if wanted.kind == "client":
            return self._open_client(wanted, name, downlink)
        if wanted.kind == "transform":
            with self._lock:
                return self._transforms.open(wanted, downlink, self._running())
        if wanted.kind != "subscription":
            return refused(wanted, f"this receiver opens no {wanted.kind} yet")
        type = wanted.type or ""
        try:
            own = described(type)
        except ImportError as error:
            return refused(wanted, f"{type} is not installed here: {error}", "type")
        publishers = self._publishers(name)
        try:
            checked = own.compare(wanted.hash, wanted.layout)
        except DifferentError as error:
            return refused(wanted, str(error), "layout")
        if (other := _other_type(own, publishers)) is not None:
            return refused(wanted, f"{name}: {other}", "type")
        is_bulk = own.is_large if wanted.bulk is None else wanted.bulk
        queue = downlink.queue(wanted, name, is_bulk=is_bulk)
        heard = Heard()
        heard.publishers = _identities(publishers)
        subscription = _Subscription(queue, own, _qos(publishers, queue.depth), heard)
        with self._lock:
            self._open[wanted.id] = subscription
            self._taker_of(subscription).add(subscription)
        return Opened(
            wanted.id,
            "opened",
            name=name,
            lane=queue.lane.name,
            latched=_is_latched(subscription.qos),
            checked=checked,
        )

    def _open_client(self, wanted: Open, name: str, downlink: Downlink) -> Opened:
        type = wanted.type or ""
        try:
            own = described_service(type)
            checked = own.compare(wanted.hash, wanted.layout)
        except ImportError as error:
            return refused(wanted, f"{type} is not installed here: {error}", "type")
        except DifferentError as error:
            return refused(wanted, str(error), "layout")
        for found, types in self._ros.parameters.get_service_names_and_types():
            if found == name and type not in types:
                reason = f"{name} is a {' and '.join(types)}, and the app calls a {type}"
                return refused(wanted, reason, "type")
        client = AppClient(wanted.id, name, own, downlink)
        with self._lock:
            self._clients[wanted.id] = client
            self._running().serve(client)
        return Opened(wanted.id, "opened", name=name, lane="ros", checked=checked)

    def close(self, id: int) -> None:
        with self._lock:
            if (subscription := self._open.pop(id, None)) is not None:
                self._taker_of(subscription).remove(subscription)
            if (client := self._clients.pop(id, None)) is not None:
                self._running().end(client)
            self._transforms.close(id)

    def received(self, frame: Frame) -> None:
        with self._lock:
            client = self._clients.get(frame.header.channel)
        if client is not None:
            client.put(frame)
            self._running().wake()

    def _taker_of(self, subscription: _Subscription) -> RawTaker | BulkTaker:
        if subscription.queue.lane is ROS:
            return self._running()
        if self._bulk_taker is None:
            self._bulk_taker = BulkTaker(self._ros.parameters, self._failed)
        return self._bulk_taker

    def _running(self) -> RawTaker:
        """Returns the taker, made with its node when the first name is opened."""
        if self._taker is None:
            main = self._ros.parameters
            self._node = rclpy.create_node(
                f"{main.get_name()}_openings",
                namespace=main.get_namespace(),
                context=main.context,
                use_global_arguments=False,
                enable_rosout=False,
                start_parameter_services=False,
            )
            self._taker = RawTaker(self._node, [], self._failed)
        return self._taker

    def _failed(self, topic: str, error: Exception) -> None:
        with self._lock:
            for subscription in self._open.values():
                if subscription.topic == topic:
                    subscription.queue.ending = f"{topic}: {error}", "type"
            for client in self._clients.values():
                if client.topic == topic:
                    client.failed(error)

    def _publishers(self, name: str) -> list[TopicEndpointInfo]:
        return list(self._ros.parameters.get_publishers_info_by_topic(name))

    def _follow(self) -> None:
        """Opens subscriptions again whose publishers have another QoS now, ends others."""
        self._transforms.send_due()
        with self._lock:
            open = list(self._open.items())
        for id, old in open:
            publishers = self._publishers(old.topic)
            old.heard.publishers = _identities(publishers)
            if (other := _other_type(old.own, publishers)) is not None:
                old.queue.ending = f"{old.topic}: {other}", "type"
            elif publishers and (qos := _qos(publishers, old.queue.depth)) != old.qos:
                self._replace(id, old, qos)

    def _replace(self, id: int, old: _Subscription, qos: QoSProfile) -> None:
        new = _Subscription(old.queue, old.own, qos, old.heard)
        with self._lock:
            if self._open.get(id) is old:
                self._open[id] = new
                self._taker_of(old).replace(old, new)


def _identities(publishers: list[TopicEndpointInfo]) -> tuple[bytes, ...]:
    return tuple(sorted(bytes(it.endpoint_gid) for it in publishers))


def _qos(publishers: list[TopicEndpointInfo], depth: int) -> QoSProfile:
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


def _is_latched(qos: QoSProfile) -> bool:
    return bool(qos.durability == DurabilityPolicy.TRANSIENT_LOCAL)


def _other_type(own: Described, publishers: list[TopicEndpointInfo]) -> str | None:
    """Returns what is wrong if a publisher has another type, or another version of it."""
    for it in publishers:
        node = f"{it.node_namespace.rstrip('/')}/{it.node_name}"
        if it.topic_type != own.type:
            return f"{node} publishes {it.topic_type}, and the app wants {own.type}"
        hash = str(it.topic_type_hash)
        if own.hash and hash.startswith("RIHS01_") and hash != own.hash:
            return f"{node} publishes {own.type} of {hash}, and this receiver has {own.hash}"
    return None
