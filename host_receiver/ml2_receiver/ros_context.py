"""How every node of the receiver and of its tools starts ROS."""

from collections.abc import Sequence

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from .errors import RosError


def start_ros(arguments: Sequence[str] = ()) -> Context:
    """A context of its own, to be ended by rclpy.shutdown(); signals stay the caller's.

    Args:
        arguments: for ROS, as `["--ros-args", ...]`.

    Raises:
        RosError: ROS does not take them.
    """
    context = Context()
    try:
        rclpy.init(
            args=["ml2-receiver", *arguments],
            context=context,
            signal_handler_options=SignalHandlerOptions.NO,
        )
    except RuntimeError as error:
        raise RosError(f"ROS 2 does not start: {error}") from error
    return context
