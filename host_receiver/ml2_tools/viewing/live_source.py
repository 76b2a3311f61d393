"""The ROS node of `ml2-receiver view`, which takes the messages of a running receiver."""

import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

from rclpy.context import Context
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker

from ..geometry.transform_tree import STATIC_DEPTH
from ..live.diagnostics import TYPE, read_diagnostics
from ..monitoring.topic_table import Rows
from .losses import RecentLosses
from .plots import CLOCK, THROUGHPUT, clock_uncertainty_ms, received_mbit_per_s
from .section_forms import receiver_state
from .state import Levels, state_of
from .subscription import Kind, Subscription
from .view import View

# Faster than a page changes, and slower than the inertial samples come.
_PAUSE_S = 0.01
_DEPTH = 100
_QOS = {
    Kind.IMAGE: QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT),
    Kind.SENSOR: QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT),
    Kind.TRANSFORMS: QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT),
    Kind.EVENTS: QoSProfile(depth=_DEPTH),
    Kind.LATCHED: QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL),
    Kind.STATIC: QoSProfile(depth=STATIC_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL),
}


class LiveSource:
    """A running receiver, as a Source.

    Args:
        receiver: the receiver's --name, or empty.

    Raises:
        RosError: ROS does not start.
    """

    def __init__(self, receiver: str) -> None:
        self._receiver, self._losses = receiver, RecentLosses()
        self._closing = ExitStack()
        self._node = self._closing.enter_context(tool_node("ml2_view"))
        self._raw: dict[Subscription, RawSubscription] = {}

    @property
    def context(self) -> Context:
        """The context for more nodes of this process; it ends with this node."""
        return self._node.context

    def start(self, view: View) -> None:
        starting = threading.Lock()

        def diagnosed(payload: bytes) -> None:
            with starting:  # the view asks for more topics at once
                found = read_diagnostics(payload).get(self._receiver)
            if found is not None:
                view.report(found.rows, found.levels)
                view.series[CLOCK].add(clock_uncertainty_ms(found.rows), self.now_s())
                view.series[THROUGHPUT].add(received_mbit_per_s(found.rows), self.now_s())

        rows = RawSubscription(TYPE, "/diagnostics", QoSProfile(depth=_DEPTH), diagnosed)
        with starting:
            self._taker = RawTaker(self._node, [rows], view.faults.add, _PAUSE_S)
        self._closing.callback(self._taker.stop)

    def close(self) -> None:
        self._closing.close()

    def now_s(self) -> float:
        return time.monotonic()

    def unix_s(self, at_s: float) -> float:
        return time.time() - self.now_s() + at_s

    def add(self, subscription: Subscription) -> None:
        def take(payload: bytes) -> None:
            subscription.take(payload, self.now_s())

        qos = _QOS[subscription.kind]
        raw = RawSubscription(subscription.type, subscription.topic, qos, take)
        self._raw[subscription] = raw
        self._taker.add(raw)

    def remove(self, subscription: Subscription) -> None:
        self._taker.remove(self._raw.pop(subscription))

    def state(self, rows: Rows, levels: Levels, modes: Mapping[str, str], battery: str) -> Any:
        recent = self._losses.count(rows, self.now_s())
        return state_of(rows, levels, modes, battery, recent) | {"doing": receiver_state(rows)}
