"""Prepares the environment before a command makes a ROS node."""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from ..errors import RosError
from ..ros.fastdds import apply_default_profile

_ROS_HINT = (
    "Run `source /opt/ros/jazzy/setup.bash`, or `make setup` in the clone and start"
    " host_receiver/ml2-receiver. `ml2-receiver record --no-ros` works without ROS 2."
)


@contextmanager
def ros_needed() -> Iterator[None]:
    """Around imports of what needs ROS. Fast DDS gets our profile, unless the user has chosen one.

    Raises:
        RosError: it is not there.
    """
    warning = apply_default_profile(os.environ)
    if warning is not None:
        print(f"WARNING: {warning}", file=sys.stderr)
    try:
        yield
    except ModuleNotFoundError as error:
        raise RosError(
            f"ROS 2 is not available: Python finds no {error.name}", hint=_ROS_HINT
        ) from error


def node_arguments(ros_args: Sequence[str], name: str) -> list[str]:
    """The user's, and the namespace of --name."""
    namespace = ["-r", f"__ns:=/{name}"] if name else []
    return ["--ros-args", *ros_args, *namespace]
