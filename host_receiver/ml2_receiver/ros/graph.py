"""Carries out the openings of apps with ROS: subscriptions, clients of services, transforms."""

import threading
from contextlib import suppress
from itertools import count
from typing import Self

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rclpy.validate_full_topic_name import validate_full_topic_name

from ..configuration.app_rules import AppRules
from ..session.downlink import Downlink
from ..session.graph import refused
from ..wire.frame import Frame
from ..wire.kinds import ROS
from ..wire.opening_bodies import Open, Opened
from .app_clients import AppClient, AppServing
from .app_services import AppService
from .app_subscriptions import AppSubscription, Heard, identities, is_latched, other_type, qos_of
from .app_transforms import AppTransforms
from .bulk_process import BulkTaker
from .layout import Described, DifferentError, described, described_service
from .node import RosNode
from .raw_taker import RawTaker
from .real_time import steady_timer

_RENEWAL_S = 0.5
_LONGEST_NAME = 255
# Messages that come 1000 times a second are taken two at a time: each turn of the taker, and of the
# writer behind it, takes the interpreter from the threads that publish samples.
_PAUSE_S = 0.001
_MASK = (1 << 32) - 1
_OF_SERVICES = ("client", "service")


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
        self._open: dict[int, AppSubscription] = {}
        self._serving: dict[int, AppClient | AppService] = {}
        # By kind and name: those whose apps have gone, and may come again
        self._left: dict[tuple[str, str], AppClient | AppService] = {}
        self._numbers = (it & _MASK for it in count())
        self._transforms = AppTransforms(node.remapped)
        steady_timer(node.parameters, _RENEWAL_S, self._renew)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bulk_taker is not None:
            self._bulk_taker.stop()
        if self._taker is not None and self._node is not None:
            self._taker.stop()
            for serving in (*self._serving.values(), *self._left.values()):
                with suppress(Exception):  # of several types; the others end, too
                    serving.end(self._node)
            self._node.destroy_node()

    @property
    def rules(self) -> AppRules:
        return self._ros.config.app

    def resolve(self, wanted: Open) -> str:
        name = wanted.name or ""
        if wanted.kind == "service" and not name.startswith(("/", "~")):
            name = f"{self._ros.config.prefix}/{name}"
        try:
            name = self._ros.remapped(name, is_service=wanted.kind in _OF_SERVICES)
            validate_full_topic_name(name)
        except Exception as error:  # of several types
            raise ValueError(f"{wanted.name!r} is no name of ROS: {error}") from error
        if len(name) > _LONGEST_NAME:
            raise ValueError(f"{name!r} has more than {_LONGEST_NAME} characters")
        return name

    def open(self, wanted: Open, name: str, downlink: Downlink) -> Opened:
        if wanted.kind in _OF_SERVICES:
            return self._open_serving(wanted, name, downlink)
        if wanted.kind == "transform":
            with self._lock:
                return self._transforms.open(wanted, downlink, self._running())
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
        if (other := other_type(own, publishers)) is not None:
            return refused(wanted, f"{name}: {other}", "type")
        is_bulk = own.is_large if wanted.bulk is None else wanted.bulk
        queue = downlink.queue(wanted, name, is_bulk=is_bulk)
        heard = Heard()
        heard.publishers = identities(publishers)
        subscription = AppSubscription(queue, own, qos_of(publishers, queue.depth), heard)
        with self._lock:
            self._open[wanted.id] = subscription
            self._taker_of(subscription).add(subscription)
        return Opened(
            wanted.id,
            "opened",
            name=name,
            lane=queue.lane.name,
            latched=is_latched(subscription.qos),
            checked=checked,
        )

    def _open_serving(self, wanted: Open, name: str, downlink: Downlink) -> Opened:
        type = wanted.type or ""
        try:
            own = described_service(type)
            checked = own.compare(wanted.hash, wanted.layout)
        except ImportError as error:
            return refused(wanted, f"{type} is not installed here: {error}", "type")
        except DifferentError as error:
            return refused(wanted, str(error), "layout")
        for found, types in self._ros.parameters.get_service_names_and_types():
            is_left = any(left == name for _, left in self._left)
            if found == name and type not in types and not is_left:
                reason = f"{name} is a {' and '.join(types)}, and the app has a {type}"
                return refused(wanted, reason, "type")
        with self._lock:
            offered = [it.topic for it in self._serving.values() if it.kind == "service"]
            if wanted.kind == "service" and name in offered:
                return refused(wanted, f"the app offers {name} already")
            self._serving[wanted.id] = self._resumed(wanted, name, own, downlink)
            self._running().wake()
        return Opened(wanted.id, "opened", name=name, lane="ros", checked=checked)

    def _resumed(
        self, wanted: Open, name: str, own: Described, downlink: Downlink
    ) -> AppClient | AppService:
        """Returns a client or service that has begun: the one that the app has left, if any."""
        serving = self._left.pop((wanted.kind, name), None)
        if serving is not None and serving.type == own.type:
            serving.resume(wanted.id, downlink)
            return serving
        if serving is not None:
            self._running().end(serving)
        if wanted.kind == "client":
            serving = AppClient(name, own, self._is_over)
        else:
            serving = AppService(name, own, self._is_over, self._numbers)
        serving.resume(wanted.id, downlink)
        self._running().serve(serving)
        return serving

    def _is_over(self, serving: AppServing) -> None:
        with self._lock:
            for key, left in list(self._left.items()):
                if left is serving:
                    del self._left[key]
                    self._running().end(left)

    def close(self, id: int) -> None:
        with self._lock:
            if (subscription := self._open.pop(id, None)) is not None:
                self._taker_of(subscription).remove(subscription)
            if (serving := self._serving.pop(id, None)) is not None:
                key = serving.kind, serving.topic
                if serving.has_failed or key in self._left:
                    self._running().end(serving)
                else:
                    self._left[key] = serving
                serving.leave()
                self._running().wake()
            self._transforms.close(id)

    def received(self, frame: Frame) -> None:
        with self._lock:
            serving = self._serving.get(frame.header.channel)
        if serving is not None:
            serving.put(frame)
            self._running().wake()

    def _taker_of(self, subscription: AppSubscription) -> RawTaker | BulkTaker:
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
            self._taker = RawTaker(self._node, [], self._failed, _PAUSE_S)
        return self._taker

    def _failed(self, topic: str, error: Exception) -> None:
        with self._lock:
            for subscription in self._open.values():
                if subscription.topic == topic:
                    subscription.queue.ending = f"{topic}: {error}", "type"
            for serving in self._serving.values():
                if serving.topic == topic:
                    serving.failed(error)

    def _publishers(self, name: str) -> list[TopicEndpointInfo]:
        return list(self._ros.parameters.get_publishers_info_by_topic(name))

    def _renew(self) -> None:
        """Opens subscriptions again whose publishers have another QoS now, ends others."""
        self._transforms.send_due()
        with self._lock:
            open = list(self._open.items())
        for id, old in open:
            publishers = self._publishers(old.topic)
            old.heard.publishers = identities(publishers)
            if (other := other_type(old.own, publishers)) is not None:
                old.queue.ending = f"{old.topic}: {other}", "type"
            elif publishers and (qos := qos_of(publishers, old.queue.depth)) != old.qos:
                self._replace(id, old, qos)

    def _replace(self, id: int, old: AppSubscription, qos: QoSProfile) -> None:
        new = AppSubscription(old.queue, old.own, qos, old.heard)
        with self._lock:
            if self._open.get(id) is old:
                self._open[id] = new
                self._taker_of(old).replace(old, new)
