"""Starts ROS for all nodes of the receiver and its tools, and ends the nodes of tools."""

import re
import threading
from collections.abc import Sequence
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from ..errors import RosError

# rcl_logging_spdlog's words for a folder it cannot make, and spdlog's for a file.
_LOG = re.compile(
    r"Failed to create log directory '([^']*)'|Failed opening file (.*)/[^/]* for writing"
)
_START_HINT = "Check what follows --ros-args, and that the RMW_IMPLEMENTATION is installed."

# How late the end is noticed.
_WAIT_S = 0.1


def start_ros(arguments: Sequence[str] = ()) -> Context:
    """A context of its own, to be ended by rclpy.shutdown(); signals stay the caller's.

    Args:
        arguments: for ROS, as `["--ros-args", ...]`.

    Raises:
        RosError: ROS does not take them, or cannot write its log.
    """
    context = Context()
    try:
        rclpy.init(
            args=["ml2-receiver", *arguments],
            context=context,
            signal_handler_options=SignalHandlerOptions.NO,
        )
    except RuntimeError as error:
        if (unwritable := _LOG.search(str(error))) is not None:
            raise RosError(
                f"ROS 2 cannot write its log to {Path(unwritable[1] or unwritable[2])}",
                hint="Name a folder that you can write: `export ROS_LOG_DIR=/tmp/ros_log`.",
            ) from error
        raise RosError(f"ROS 2 does not start: {error}", hint=_START_HINT) from error
    return context


def spin_until(stopping: threading.Event, node: Node, context: Context) -> None:
    """Runs the node's callbacks until `stopping` is set, then ends the node and its context."""
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    while not stopping.is_set():
        executor.spin_once(timeout_sec=_WAIT_S)
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)
