"""The ROS node of `ml2-receiver view`."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Mapping, Set
from contextlib import ExitStack, suppress
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_receiver.topics.message_types import message_class
from ml2_receiver.topics.status_name import split_status_name
from ml2_receiver.topics.string_message import decode_string

from ..geometry.transform_tree import STATIC_DEPTH
from ..monitoring.topic_table import Rows
from .cloud import CLOUD, Cloud
from .newest_image import NewestImage
from .plots import (
    CLOCK,
    SENSOR_PLOTS,
    THROUGHPUT,
    UNITS,
    Plot,
    Series,
    clock_uncertainty_ms,
    received_mbit_per_s,
)
from .scene import SCENE, Scene
from .state import image_streams, mode_in_words, published_images, state_of, topic_prefix

_BATTERY, _CONFIG = "battery", "config"
_DEPTH = 10
_IMAGE = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_SENSOR = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
_STATIC = QoSProfile(depth=STATIC_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class LiveView:
    """Images and state of one receiver, for browsers. Thread-safe.

    Threads of its own take the messages. It subscribes to images while a browser shows them, and
    to sensors while there is a browser.

    Args:
        receiver: the receiver's --name, or empty.
        with_eyes: True if browsers may ask for images of eye cameras.

    Attributes:
        changed: notified when there is a new image or a new state.
        images: the newest image of each stream that browsers may ask for.
        scene: the poses of the 3D view.
        cloud: the points of the 3D view.
        series: the values of each plot.

    Raises:
        RosError: ROS does not start.
    """

    def __init__(self, receiver: str, with_eyes: bool) -> None:
        self._receiver = receiver
        self.changed = threading.Condition()
        self.images = {it: NewestImage(it) for it in image_streams(with_eyes)}
        self.scene = Scene(receiver)
        self.cloud = Cloud(self.scene)
        self.series = {name: Series() for name in UNITS}
        self._state: tuple[int, str] = 0, ""
        self._rows: Rows = {}
        self._modes: dict[str, str] = {}
        self._battery = "not reported"
        self._watched: dict[object, frozenset[str]] = {}
        self._in_scene: Mapping[str, tuple[str, str]] = {}
        # By what they fill and their topic.
        self._subscriptions: dict[tuple[str, str], RawSubscription] = {}
        self._settling = threading.Lock()
        self._closing = ExitStack()
        node = self._closing.enter_context(tool_node("ml2_view"))
        self._context: Context = node.context
        type = "diagnostic_msgs/msg/DiagnosticArray"
        rows = RawSubscription(type, "/diagnostics", QoSProfile(depth=_DEPTH), self._diagnosed)
        with self._settling:  # _diagnosed() needs _taker, and may be called at once
            self._taker = RawTaker(node, [rows])
        self._closing.callback(self._taker.stop)

    def close(self) -> None:
        """Ends the node; no method may be called afterwards."""
        self._closing.close()

    @property
    def context(self) -> Context:
        """The context for more nodes of this process; it ends with this node."""
        return self._context

    @property
    def offered(self) -> Set[str]:
        """The streams, and parts of the 3D view, that browsers may ask for."""
        return self.images.keys() | {SCENE, CLOUD}

    @property
    def is_watched(self) -> bool:
        """True while a browser is connected."""
        return bool(self._watched)

    @property
    def state(self) -> tuple[int, str]:
        """The number of the newest state, from 1, and its JSON; 0 before the first."""
        return self._state

    def watch(self, browser: object, streams: frozenset[str] | None) -> None:
        """Sets what of `offered` a browser shows; None once the browser is gone."""
        with self._settling:
            if streams is None:
                self._watched.pop(browser, None)
            else:
                self._watched[browser] = streams
            self._settle()

    def _settle(self) -> None:
        """Subscribes to what is watched and published, and to nothing else."""
        wanted = self._wanted() if self._watched else {}
        for key in self._subscriptions.keys() - wanted.keys():
            self._taker.remove(self._subscriptions.pop(key))
            if (stream := key[0]) in self.images:  # nobody may see an old image as a new one
                self.images[stream] = NewestImage(stream)
        for key in wanted.keys() - self._subscriptions.keys():
            self._subscriptions[key] = self._subscription(*key, wanted[key])
            self._taker.add(self._subscriptions[key])

    def _wanted(self) -> dict[tuple[str, str], str]:
        """Returns the types of the wanted topics, by what they fill and their name."""
        images = published_images(self._rows)
        found = {
            stream: images[stream]
            for streams in self._watched.values()
            for stream in streams & images.keys()
        }
        topics = {
            it["stream"]: (name, it["type"]) for name, it in self._rows.items() if "type" in it
        }
        for plot in SENSOR_PLOTS.values():
            if (stream := next((it for it in plot.streams if it in topics), None)) is not None:
                found[plot.name] = topics[stream]
        if _BATTERY in topics:
            found[_BATTERY] = topics[_BATTERY]
        shown = frozenset[str]().union(*self._watched.values())
        if SCENE in shown:
            self._in_scene = self.scene.topics(self._rows, shown)
            found |= self._in_scene
        if (prefix := topic_prefix(self._rows)) is not None:
            found[_CONFIG] = f"{prefix}/config", "std_msgs/msg/String"
        return {(name, topic): type for name, (topic, type) in found.items()}

    def _subscription(self, name: str, topic: str, type: str) -> RawSubscription:
        if name in self.images:
            take = partial(self._take_image, self.images[name], type)
            return RawSubscription(type, topic, _IMAGE, take)
        if name in self._in_scene:
            qos = _STATIC if topic == "/tf_static" else _SENSOR
            return RawSubscription(type, topic, qos, partial(self.scene.take, name, type))
        if name == _CONFIG:
            return RawSubscription(type, topic, _LATCHED, self._configured)
        use = self._charged if name == _BATTERY else partial(self._add, SENSOR_PLOTS[name])
        decoded = partial(self._take_sensor, message_class(type), use)
        return RawSubscription(type, topic, _SENSOR, decoded)

    def _take_image(self, image: NewestImage, type: str, payload: bytes) -> None:
        if image.take(type, payload):
            with self.changed:
                self.changed.notify_all()

    def _take_sensor(self, type: Any, use: Callable[[Any], None], payload: bytes) -> None:
        # A headset's bytes that are not of the type must not end the thread.
        with suppress(RuntimeError):
            use(deserialize_message(payload, type))

    def _add(self, plot: Plot, message: Any) -> None:
        self.series[plot.name].add(plot.read(message))

    def _charged(self, message: Any) -> None:
        if math.isfinite(message.percentage):
            self._battery = f"{message.percentage * 100:.0f} %"

    def _configured(self, payload: bytes) -> None:
        with suppress(ValueError, KeyError, AttributeError, TypeError, RecursionError):
            streams = json.loads(decode_string(payload))["streams"]
            values = {stream: answer.get("values") for stream, answer in streams.items()}
            self._modes = {stream: mode_in_words(it) for stream, it in values.items()}

    def _diagnosed(self, payload: bytes) -> None:
        rows: dict[str, dict[str, str]] = {}
        levels: dict[str, int] = {}
        for status in deserialize_message(payload, DiagnosticArray).status:
            receiver, row = split_status_name(status.name) or (None, "")
            if receiver == self._receiver:
                values = {pair.key: pair.value for pair in status.values}
                rows[row] = values | {"message": status.message}
                levels[row] = status.level[0]
        if rows:
            self._reported(rows, levels)

    def _reported(self, rows: Rows, levels: Mapping[str, int]) -> None:
        with self._settling:
            self._rows = rows
            self._settle()
        try:
            self.series[CLOCK].add(clock_uncertainty_ms(rows))
            self.series[THROUGHPUT].add(received_mbit_per_s(rows))
            state = state_of(rows, levels, self._modes, self._battery)
        except (KeyError, ValueError) as error:
            reason = f"the receiver's version has another /diagnostics: {error!r}"
            state = {"type": "state", "problem": reason}
        with self.changed:
            self._state = self._state[0] + 1, json.dumps(state)
            self.changed.notify_all()
