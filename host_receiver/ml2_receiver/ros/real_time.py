"""What of a node goes by real time, whatever the PC's clock and ROS's time do."""

import time
from collections.abc import Callable

from builtin_interfaces.msg import Time
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.timer import Timer

_NANOS_PER_SECOND = 1_000_000_000


def steady_timer(node: Node, period_s: float, callback: Callable[[], None]) -> Timer:
    """A timer that runs on, in the node's executor, when clocks step back or ROS's time stops."""
    return node.create_timer(period_s, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def real_time() -> Time:
    """Returns the time of the clock that stamps the data of sensors, also with use_sim_time."""
    sec, nanosec = divmod(time.time_ns(), _NANOS_PER_SECOND)
    return Time(sec=sec, nanosec=nanosec)


def say_real_time(node: Node) -> None:
    """Says in the log that use_sim_time does not reach the stamps, if the node has it."""
    if node.get_parameter("use_sim_time").value:
        node.get_logger().warning(
            "use_sim_time is set: sensor stamps and /diagnostics stay in real time"
        )
