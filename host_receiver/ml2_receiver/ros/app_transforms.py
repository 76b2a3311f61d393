"""The transforms that apps have open: poses from one buffer, thinned to what each app wants."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from rclpy.qos import DurabilityPolicy, QoSProfile

from ..session.downlink import Downlink
from ..session.graph import refused
from ..topics.transform_buffer import TransformBuffer, TransformError
from ..wire.kinds import Kind
from ..wire.opening_bodies import Open, Opened, Pose
from .layout import described, plain
from .raw_taker import RawSubscription, RawTaker

_TYPE = "tf2_msgs/msg/TFMessage"
_DEPTH = 100
# The rate of a headset's display.
_MOST_HZ = 120.0


@dataclass
class _Wanted:
    id: int
    frame: str
    reference: str
    downlink: Downlink
    period_s: float
    due_s: float = 0.0
    sent: Pose | None = None

    def send(self, buffer: TransformBuffer, now_s: float) -> None:
        """Sends the pose if it is due and has changed; the newest takes the place of others."""
        if now_s < self.due_s:
            return
        # Also without a new pose: other transforms may come much faster
        self.due_s = now_s + self.period_s
        try:
            found = buffer.look_up(self.frame, self.reference)
        except TransformError:
            return
        pose = Pose(*found.pose.translation, *found.pose.rotation, found.newest_ns)
        if pose != self.sent:
            self.sent = pose
            body = pose.to_bytes()
            self.downlink.send(Kind.POSE, self.id, 0, body, found.stamp_ns, is_latest=True)


class AppTransforms:
    """Subscribes to /tf and /tf_static while an app has a transform open. Thread-safe.

    Args:
        remapped: returns the name that ROS has for a topic.
    """

    def __init__(self, remapped: Callable[[str], str]) -> None:
        self._remapped = remapped
        self._lock = threading.Lock()
        self._layout = ""
        self._buffer = TransformBuffer()
        self._wanted: dict[int, _Wanted] = {}
        self._subscriptions: list[RawSubscription] = []
        self._taker: RawTaker | None = None

    def open(self, wanted: Open, downlink: Downlink, taker: RawTaker) -> Opened:
        """Begins to send poses; `taker` takes the transforms."""
        try:
            self._layout = described(_TYPE).layout
        except ImportError as error:
            return refused(wanted, f"{_TYPE} is not installed here: {error}", "type")
        frame, reference = (str(it).lstrip("/") for it in (wanted.frame, wanted.reference))
        period_s = 1 / min(wanted.max_hz or _MOST_HZ, _MOST_HZ)
        name = self._remapped("/tf")
        with self._lock:
            made = _Wanted(wanted.id, frame, reference, downlink, period_s)
            self._wanted[wanted.id] = made
            if self._subscriptions:
                made.send(self._buffer, time.monotonic())
            else:
                self._buffer, self._taker = TransformBuffer(), taker
                static = QoSProfile(depth=_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
                self._subscriptions = [
                    self._subscription(name, QoSProfile(depth=_DEPTH), is_static=False),
                    self._subscription(self._remapped("/tf_static"), static, is_static=True),
                ]
                for subscription in self._subscriptions:
                    taker.add(subscription)
        return Opened(wanted.id, "opened", name=name, lane="ros")

    def _subscription(self, name: str, qos: QoSProfile, *, is_static: bool) -> RawSubscription:
        return RawSubscription(_TYPE, name, qos, partial(self._put, is_static=is_static))

    def close(self, id: int) -> None:
        """Ends an opening, if it is a transform."""
        with self._lock:
            self._wanted.pop(id, None)
            if not self._wanted and self._taker is not None:
                for subscription in self._subscriptions:
                    self._taker.remove(subscription)
                self._subscriptions = []

    def _put(self, payload: bytes, *, is_static: bool) -> None:
        message = plain(payload, self._layout)
        with self._lock:
            self._buffer.add_message(message, is_static=is_static)
        self.send_due()

    def send_due(self) -> None:
        """Sends the poses that are due."""
        now_s = time.monotonic()
        with self._lock:
            for wanted in self._wanted.values():
                wanted.send(self._buffer, now_s)
