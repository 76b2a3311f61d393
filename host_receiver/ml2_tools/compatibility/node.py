"""The ROS node that publishes the thesis's topics."""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.subscription import Subscription
from std_msgs.msg import String

from ml2_receiver.errors import ProtocolError
from ml2_receiver.ros.context import spin_until, start_node_named
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.message_types import message_class

from ..monitoring.losses import Losses
from .thesis import configuration_text, metadata_text, rotate_imu

_DEPTH = 10
_CONFIG, _REQUEST = "/MagicLeap/config", "/request"
# The older topics of the thesis have one gyroscope and one accelerometer. Which unit it was is not
# known; the left one stands in.
_OLDER_NAMES = {"gyro": "gyro_left", "accel": "accel_left"}


@dataclass(frozen=True)
class _Conversion:
    """A topic that is converted from another."""

    source: Topic
    convert: Callable[[Any], Any]


class CompatibilityNode:
    """The node `ml2_compat`: republishes below `out` while somebody subscribes there.

    Args:
        prefix: the prefix of the receiver's topics.
        out: the prefix of the published topics.
        arguments: ROS arguments, `["--ros-args", ...]`.

    Raises:
        RosError: ROS rejects the arguments.
    """

    def __init__(self, prefix: str, out: str, arguments: Sequence[str]) -> None:
        self.losses = Losses()
        self._prefix = prefix
        self._node = start_node_named("ml2_compat", arguments)
        self._conversions = _conversions()
        self._subscriptions: dict[str, Subscription] = {}
        self._publishers = {
            name: self._node.create_publisher(
                message_class(it.source.type),
                f"{out}/{name}",
                _DEPTH,
                event_callbacks=PublisherEventCallbacks(matched=lambda _: self._subscribe()),
            )
            for name, it in self._conversions.items()
        }
        self._applied: str | None = None
        self._configs: Publisher = self._node.create_publisher(String, _CONFIG, _DEPTH)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._node.create_subscription(String, f"{prefix}/config", self._take_config, latched)
        self._node.create_subscription(String, _REQUEST, lambda _: self._answer(), _DEPTH)

    def spin(self, stopping: threading.Event) -> None:
        """Runs the node until `stopping` is set, then ends it."""
        spin_until(stopping, self._node)

    def _subscribe(self) -> None:
        wanted = {it for it in self._publishers if self._publishers[it].get_subscription_count()}
        for name in self._subscriptions.keys() - wanted:
            self._node.destroy_subscription(self._subscriptions.pop(name))
        for name in wanted - self._subscriptions.keys():
            source = self._conversions[name].source
            self._subscriptions[name] = self._node.create_subscription(
                message_class(source.type),
                source.full_name(self._prefix),
                partial(self._republish, name),
                load_table().qos[source.qos].depth,
            )

    def _republish(self, name: str, message: Any) -> None:
        try:
            self._publishers[name].publish(self._conversions[name].convert(message))
        except ValueError as error:
            self.losses.add(f"{name}: {error}")

    def _take_config(self, message: Any) -> None:
        self._applied = message.data

    def _answer(self) -> None:
        """Publishes the configuration, as the thesis's node did, once a headset is configured."""
        if self._applied is None:
            self.losses.add(f"{_REQUEST}: no headset was configured yet")
            return
        try:
            self._configs.publish(String(data=configuration_text(self._applied, self._prefix)))
        except ProtocolError as error:
            self.losses.add(f"config: {error}")


def _conversions() -> Mapping[str, _Conversion]:
    """Returns the conversions by topic name below `out`."""
    conversions = {}
    for stream in load_table().streams.values():
        for topic in stream.topics:
            if topic.role == "metadata":
                conversions[topic.name] = _Conversion(topic, _text)
            if topic.role == "imu" and stream.section == "other_sensors":
                frame = f"magicleap_{stream.id.removesuffix('_pack')}"
                conversions[topic.name] = _Conversion(topic, partial(rotate_imu, frame=frame))
    for older_name, stream_id in _OLDER_NAMES.items():
        (topic,) = load_table().streams[stream_id].topics
        frame = f"magicleap_{older_name}"
        conversions[f"{older_name}/imu"] = _Conversion(topic, partial(rotate_imu, frame=frame))
    return conversions


def _text(message: Any) -> Any:
    return String(data=metadata_text(message.data))
