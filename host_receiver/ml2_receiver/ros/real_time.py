"""Timers and stamps of a node that neither steps of the PC's clock nor use_sim_time affect."""

import time
from collections.abc import Callable

from builtin_interfaces.msg import Time
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.timer import Timer

_NANOS_PER_SECOND = 1_000_000_000


def steady_timer(node: Node, period_s: float, callback: Callable[[], None]) -> Timer:
    """Returns a timer on the monotonic clock; the node's executor calls `callback`."""
    return node.create_timer(period_s, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def real_time() -> Time:
    """Returns the system's time, which also stamps the sensors' data; use_sim_time is ignored."""
    sec, nanosec = divmod(time.time_ns(), _NANOS_PER_SECOND)
    return Time(sec=sec, nanosec=nanosec)


def say_real_time(node: Node) -> None:
    """Logs a warning if use_sim_time is set, because stamps do not follow it."""
    if node.get_parameter("use_sim_time").value:
        node.get_logger().warning(
            "use_sim_time is set: sensor stamps and /diagnostics stay in real time"
        )
