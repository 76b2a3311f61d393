"""Starts ROS for all nodes of the receiver and its tools, and ends the nodes of tools."""

import re
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from ..errors import RosError
from .given_arguments import given

# The messages of rcl_logging_spdlog for a folder, and of spdlog for a file, that cannot be made.
_LOG = re.compile(
    r"Failed to create log directory '([^']*)'|Failed opening file (.*)/[^/]* for writing"
)
_START_HINT = (
    "Check what follows --ros-args, that the RMW_IMPLEMENTATION is installed, and the variables"
    " ROS_SECURITY_*."
)

# The longest delay until the end is noticed.
_WAIT_S = 0.1


def start_node[Made: Node](
    make: Callable[[Context], Made], arguments: Sequence[str] | None = None
) -> Made:
    """Starts ROS in a new context, to be ended with rclpy.shutdown(), and makes its first node.

    That node starts the middleware. Signals are not handled.

    Args:
        make: makes the node; if it raises, ROS ends.
        arguments: arguments for ROS, such as `["--ros-args", ...]`; default: the command's own.

    Raises:
        RosError: ROS refuses the arguments, cannot write its log, or its middleware does not start.
    """
    context = Context()
    try:
        with ExitStack() as failing:
            failing.callback(context.try_shutdown)
            rclpy.init(
                args=["ml2-receiver", *(given() if arguments is None else arguments)],
                context=context,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            node = make(context)
            failing.pop_all()
            return node
    except RuntimeError as error:
        if (unwritable := _LOG.search(str(error))) is not None:
            raise RosError(
                f"ROS 2 cannot write its log to {Path(unwritable[1] or unwritable[2])}",
                hint="Name a folder that you can write: `export ROS_LOG_DIR=/tmp/ros_log`.",
            ) from error
        raise RosError(f"ROS 2 does not start: {error}", hint=_START_HINT) from error


def start_node_named(name: str, arguments: Sequence[str] | None = None) -> Node:
    """Works as start_node(), for a plain node."""
    return start_node(lambda context: rclpy.create_node(name, context=context), arguments)


@contextmanager
def tool_node(name: str) -> Iterator[Node]:
    """A node in a context of its own; both end with the block.

    Raises:
        RosError: ROS does not start.
    """
    node = start_node_named(name)
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.shutdown(context=node.context)


def count_publishers(node: Node, topic: str) -> int:
    """Returns how many publish on the topic to which `node` would subscribe by this name."""
    return node.count_publishers(node.resolve_topic_name(topic))


def spin_until(stopping: threading.Event, node: Node) -> None:
    """Runs the node's callbacks until `stopping` is set, then ends the node and its context."""
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    while not stopping.is_set():
        executor.spin_once(timeout_sec=_WAIT_S)
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=node.context)
