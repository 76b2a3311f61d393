"""The ROS node of the thesis's topics."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import rclpy
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.subscription import Subscription
from std_msgs.msg import String

from ml2_receiver.errors import ProtocolError
from ml2_receiver.ros.context import spin_until, start_ros
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.message_types import message_class

from ..monitoring.losses import Losses
from .thesis import configuration_text, metadata_text, turn_imu

_DEPTH = 10
_CONFIG, _REQUEST = "/MagicLeap/config", "/request"
# Before it told the units apart, it had one of each; which one is not known.
_FORMER = {"gyro": "gyro_left", "accel": "accel_left"}


@dataclass(frozen=True)
class _Turned:
    """A topic made of another."""

    source: Topic
    convert: Callable[[Any], Any]


class CompatibilityNode:
    """The node `ml2_compat`: republishes below `out` while somebody subscribes there.

    Args:
        prefix: of the receiver's topics.
        arguments: for ROS, as `["--ros-args", ...]`.

    Raises:
        RosError: ROS does not take them.
    """

    def __init__(self, prefix: str, out: str, arguments: Sequence[str]) -> None:
        self.losses = Losses()
        self._prefix = prefix
        self._context = start_ros(arguments)
        self._node = rclpy.create_node("ml2_compat", context=self._context)
        self._made = _made_topics()
        self._subscriptions: dict[str, Subscription] = {}
        self._publishers = {
            name: self._node.create_publisher(
                message_class(it.source.type),
                f"{out}/{name}",
                _DEPTH,
                event_callbacks=PublisherEventCallbacks(matched=lambda _: self._subscribe()),
            )
            for name, it in self._made.items()
        }
        self._applied: str | None = None
        self._configs: Publisher = self._node.create_publisher(String, _CONFIG, _DEPTH)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._node.create_subscription(String, f"{prefix}/config", self._configured, latched)
        self._node.create_subscription(String, _REQUEST, lambda _: self._answer(), _DEPTH)

    def spin(self, stopping: threading.Event) -> None:
        """Works until `stopping` is set, then ends the node."""
        spin_until(stopping, self._node, self._context)

    def _subscribe(self) -> None:
        wanted = {it for it in self._publishers if self._publishers[it].get_subscription_count()}
        for name in self._subscriptions.keys() - wanted:
            self._node.destroy_subscription(self._subscriptions.pop(name))
        for name in wanted - self._subscriptions.keys():
            source = self._made[name].source
            self._subscriptions[name] = self._node.create_subscription(
                message_class(source.type),
                source.full_name(self._prefix),
                partial(self._republish, name),
                load_table().qos[source.qos].depth,
            )

    def _republish(self, name: str, message: Any) -> None:
        try:
            self._publishers[name].publish(self._made[name].convert(message))
        except ValueError as error:
            self.losses.add(f"{name}: {error}")

    def _configured(self, message: Any) -> None:
        self._applied = message.data

    def _answer(self) -> None:
        """As its configuration node did, once there is a headset with a configuration."""
        if self._applied is None:
            self.losses.add(f"{_REQUEST}: no headset was configured yet")
            return
        try:
            self._configs.publish(String(data=configuration_text(self._applied, self._prefix)))
        except ProtocolError as error:
            self.losses.add(f"config: {error}")


def _made_topics() -> Mapping[str, _Turned]:
    """By name below `out`."""
    made = {}
    for stream in load_table().streams.values():
        for topic in stream.topics:
            if topic.role == "metadata":
                made[topic.name] = _Turned(topic, _text)
            if topic.role == "imu" and stream.section == "other_sensors":
                frame = f"magicleap_{stream.id.removesuffix('_pack')}"
                made[topic.name] = _Turned(topic, partial(turn_imu, frame=frame))
    for former, stream_id in _FORMER.items():
        (topic,) = load_table().streams[stream_id].topics
        frame = f"magicleap_{former}"
        made[f"{former}/imu"] = _Turned(topic, partial(turn_imu, frame=frame))
    return made


def _text(message: Any) -> Any:
    return String(data=metadata_text(message.data))
