"""Starts ROS for all nodes of the receiver and its tools, and ends the nodes of tools."""

import ctypes
import re
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_rmw_implementation_identifier, try_shutdown

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

_PARTICIPANT = "_ZN16rmw_fastrtps_cpp22get_domain_participantEP10rmw_node_s"
_SET_LISTENER = (
    "_ZN8eprosima7fastdds3dds17DomainParticipant12set_listenerEPNS1_25DomainParticipantListener"
    "ENSt6chrono8durationIlSt5ratioILl1ELl1EEEE"
)
_LISTENER_S = 2


def start_node[Made: Node](
    make: Callable[[Context], Made], arguments: Sequence[str] | None = None
) -> Made:
    """Starts ROS in a new context, to be ended with end_node(), and makes its first node.

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
        end_node(node)


def end_node(node: Node) -> None:
    """Ends the last node of a context, and the context."""
    _end_discovery(node)
    node.destroy_node()
    try_shutdown(context=node.context)


def _end_discovery(node: Node) -> None:
    """Takes the listener from Fast DDS that hears of other nodes, as the end of the node does, too.

    Both wait for a call of it under way. Without a time limit, as at the end, a Fast DDS that was
    built for a glibc before 2.30, as that of the wheels, hangs then, for it keeps the lock that the
    call needs: https://github.com/eProsima/Fast-DDS/issues/6513
    """
    if get_rmw_implementation_identifier() != "rmw_fastrtps_cpp":
        return
    with suppress(AttributeError), node.handle:  # another version, without these functions
        set_listener = getattr(fastdds_library(), _SET_LISTENER)
        if participant := fastdds_participant(node):
            set_listener(ctypes.c_void_p(participant), None, ctypes.c_long(_LISTENER_S))


def fastdds_library() -> ctypes.CDLL:
    """Returns ROS's library for Fast DDS, which has the functions of Fast DDS, too."""
    return ctypes.CDLL("librmw_fastrtps_cpp.so")


def fastdds_participant(node: Node) -> int | None:
    """Returns the address of Fast DDS's participant for the context of a node."""
    of_rmw = ctypes.CDLL("librcl.so").rcl_node_get_rmw_handle
    participant = getattr(fastdds_library(), _PARTICIPANT)
    of_rmw.restype = participant.restype = ctypes.c_void_p
    rmw_node = of_rmw(ctypes.c_void_p(node.handle.pointer))
    found: int | None = participant(ctypes.c_void_p(rmw_node))
    return found


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
    end_node(node)
