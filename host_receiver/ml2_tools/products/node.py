"""The ROS node that publishes the products."""

import json
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from ml2_receiver.ros.context import count_publishers, spin_until, start_node_named
from ml2_receiver.ros.real_time import real_time, say_real_time, steady_timer
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.message_types import message_class
from ml2_receiver.topics.stamps import header_stamp_ns

from ..geometry.camera import metadata_stamp_ns
from ..geometry.transform_tree import STATIC_DEPTH, Tree
from ..images.image_topic import image_topic
from .product import Points, Product, Raw, Shared, all_products

_PERIOD_S = 1.0
_TF, _TF_STATIC = "/tf", "/tf_static"


class ProductsNode:
    """The node `ml2_products`: makes each product only while the product has subscribers.

    It publishes the number of messages per product, and losses by reason, to /diagnostics.

    Args:
        prefix: the prefix of the receiver's topics and of the products.
        frame_prefix: the prefix of the headset's frame ids.
        arguments: ROS arguments, `["--ros-args", ...]`.

    Raises:
        RosError: ROS rejects the arguments.
    """

    def __init__(self, prefix: str, frame_prefix: str, arguments: Sequence[str]) -> None:
        self._table, self._prefix = load_table(), prefix
        self._node = start_node_named("ml2_products", arguments)
        self._shared = Shared()
        self._products = all_products(self._shared)
        cameras = {camera for product in self._products for camera in product.inputs}
        self._tree = Tree(
            {frame_prefix + self._table.streams[camera].frame: camera for camera in cameras},
            frame_prefix + self._table.world_frame,
            frame_prefix + self._table.head_frame,
        )
        self._published: Counter[str] = Counter()
        self._busy_s: defaultdict[str, float] = defaultdict(float)
        self._subscriptions: dict[str, Subscription] = {}
        self._publishers = {
            topic: self._publisher(topic, type)
            for product in self._products
            if not isinstance(product, Raw)
            for topic, type in product.types.items()
        }
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._node.create_subscription(String, f"{prefix}/config", self._take_config, latched)
        static = QoSProfile(depth=STATIC_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._node.create_subscription(TFMessage, _TF_STATIC, self._take_static, static)
        self._statuses = self._node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        steady_timer(self._node, _PERIOD_S, self._tick)
        say_real_time(self._node)

    def spin(self, stopping: threading.Event) -> None:
        """Runs the node until `stopping` is set, then ends it."""
        spin_until(stopping, self._node)

    def _publisher(self, topic: str, type: str) -> Publisher:
        return self._node.create_publisher(
            message_class(type),
            f"{self._prefix}/{topic}",
            self._table.qos["image"].depth,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            event_callbacks=PublisherEventCallbacks(matched=lambda _: self._subscribe()),
        )

    def _active(self) -> list[Product]:
        return [product for product in self._products if self._is_wanted(product)]

    def _is_wanted(self, product: Product) -> bool:
        publishers = (self._publishers.get(topic) for topic in product.types)
        return any(it.get_subscription_count() for it in publishers if it is not None)

    def _offer_raw(self) -> None:
        """Offers a raw image only while the compressed one is published and nobody else offers it.

        The raw image has the topic on which the headset publishes it in another format.
        """
        for product in self._products:
            if not isinstance(product, Raw):
                continue
            ((topic, type),) = product.types.items()
            is_own = topic in self._publishers
            is_free = self._count_publishers(topic) <= is_own
            if not (is_free and self._count_publishers(product.compressed)):
                if is_own:
                    self._node.destroy_publisher(self._publishers.pop(topic))
            elif not is_own:
                self._publishers[topic] = self._publisher(topic, type)

    def _count_publishers(self, topic: str) -> int:
        return count_publishers(self._node, f"{self._prefix}/{topic}")

    def _subscribe(self) -> None:
        """Subscribes to the inputs of the products that have subscribers, and to nothing else."""
        for product in self._products:
            if isinstance(product, Points):
                image = self._topic("color", "image").full_name(self._prefix)
                product.colour(count_publishers(self._node, image) > 0)
        wanted = {
            (camera, part)
            for product in self._active()
            for camera, parts in product.inputs.items()
            for part in parts
            if part != "transform"
        }
        sources = {self._topic(*it).full_name(self._prefix): it for it in wanted}
        needs_tf = any(
            "transform" in parts for it in self._active() for parts in it.inputs.values()
        )
        for name in self._subscriptions.keys() - sources.keys() - ({_TF} if needs_tf else set()):
            self._node.destroy_subscription(self._subscriptions.pop(name))
        for name in sources.keys() - self._subscriptions.keys():
            self._subscriptions[name] = self._subscription(name, *sources[name])
        if needs_tf and _TF not in self._subscriptions:
            depth = self._table.qos["tf"].depth
            self._subscriptions[_TF] = self._node.create_subscription(
                TFMessage, _TF, self._take_transforms, depth
            )

    def _topic(self, camera: str, role: str) -> Topic:
        if role == "image":
            return image_topic(camera, self._prefix, partial(count_publishers, self._node))
        return next(it for it in self._table.streams[camera].topics if it.role == role)

    def _subscription(self, name: str, camera: str, part: str) -> Subscription:
        topic = self._topic(camera, part)
        take = self._metadata_taker(camera) if part == "metadata" else self._taker(camera, part)
        depth = self._table.qos[topic.qos].depth
        return self._node.create_subscription(message_class(topic.type), name, take, depth)

    def _taker(self, camera: str, part: str) -> Callable[[Any], None]:
        return lambda message: self._take(camera, part, header_stamp_ns(message.header), message)

    def _metadata_taker(self, camera: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            try:
                stamp_ns = metadata_stamp_ns(message.data)
            except ValueError as error:
                self._shared.losses.add(f"{camera}: {error}")
                return
            self._take(camera, "metadata", stamp_ns, message.data)

        return take

    def _take_transforms(self, message: Any) -> None:
        try:
            for camera, stamp_ns, pose in self._tree.poses(message):
                self._take(camera, "transform", stamp_ns, pose)
        except ValueError as error:
            self._shared.losses.add(f"{_TF}: {error}")

    def _take_static(self, message: Any) -> None:
        try:
            self._tree.stand(message)
        except ValueError as error:
            self._shared.losses.add(f"{_TF_STATIC}: {error}")

    def _take(self, camera: str, part: str, stamp_ns: int, value: Any) -> None:
        for product in self._active():
            began_s = time.perf_counter()
            try:
                messages = product.add(camera, part, stamp_ns, value)
            except ValueError as error:
                self._shared.losses.add(f"{next(iter(product.types))}: {error}")
                continue
            for topic, message in messages.items():
                self._publishers[topic].publish(message)
                self._published[topic] += 1
                self._busy_s[topic] += time.perf_counter() - began_s

    def _take_config(self, message: Any) -> None:
        try:
            depth = json.loads(message.data)["streams"].get("depth", {"values": {}})
            self._shared.is_radial = bool(depth["values"].get("radial", False))
        except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
            self._shared.losses.add(f"config: {type(error).__name__}: {error}")

    def _tick(self) -> None:
        self._offer_raw()
        self._subscribe()
        array = DiagnosticArray(status=[self._status(topic) for topic in self._publishers])
        array.status.append(self._losses())
        array.header.stamp = real_time()
        self._statuses.publish(array)

    def _status(self, topic: str) -> DiagnosticStatus:
        count = self._published[topic]
        values = {"published": str(count)}
        if count:
            values["mean_ms"] = f"{self._busy_s[topic] / count * 1000:.3f}"
        is_wanted = self._publishers[topic].get_subscription_count() > 0
        return _diagnostic(f"{self._prefix}/{topic}", "made" if is_wanted else "idle", values)

    def _losses(self) -> DiagnosticStatus:
        losses = {reason: str(count) for reason, count in self._shared.losses.counts().items()}
        status = _diagnostic("losses", "since the start", losses)
        status.level = DiagnosticStatus.WARN if losses else DiagnosticStatus.OK
        return status


def _diagnostic(name: str, message: str, values: dict[str, str]) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=DiagnosticStatus.OK,
        name=f"ml2_products: {name}",
        message=message,
        hardware_id="magic_leap_2",
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
