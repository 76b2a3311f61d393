"""Prepares the environment before a command makes a ROS node."""

import argparse
import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise

from ..errors import RosError
from ..ros.fastdds import apply_default_profile
from ..ros.given_arguments import give
from .options import name

_ROS_HINT = (
    "Run `source /opt/ros/jazzy/setup.bash`, or `make setup` in the clone and start"
    " host_receiver/ml2-receiver. `ml2-receiver record --no-ros` works without ROS 2."
)

_REMAP = ("-r", "--remap")
_WITHOUT_VALUE = (*_REMAP, "--ros-args", "--")
_IDENTITY = re.compile(r"(?:[^:]*:)?__(ns|node|name):=")
_NODE_IN_RULE = re.compile(r"^\w+:(?!=|//)")
_NODE = "ml2_receiver"
# A rule may begin with the name of its node and a colon.
_NAMESPACE = re.compile(r"(?:(\w*):)?__ns:=/?(.*)")
_RENAMED = re.compile(rf"(?:{_NODE}:)?__(?:node|name):=([A-Za-z_]\w*)", re.ASCII)


@contextmanager
def ros_needed(*, sends_images: bool = False) -> Iterator[None]:
    """Guards imports that need ROS. Fast DDS gets our profile, unless the user has chosen one.

    ROS logs to standard error: standard output is the command's own, and may be JSON.

    Args:
        sends_images: the process will publish images.

    Raises:
        RosError: it is not there.
    """
    os.environ["RCUTILS_LOGGING_USE_STDOUT"] = "0"
    warning = apply_default_profile(os.environ, sends_images=sends_images)
    if warning is not None:
        print(f"WARNING: {warning}", file=sys.stderr)
    try:
        yield
    except ModuleNotFoundError as error:
        raise RosError(
            f"ROS 2 is not available: Python finds no {error.name}", hint=_ROS_HINT
        ) from error


@contextmanager
def ros_args_of(options: argparse.Namespace) -> Iterator[None]:
    """Gives the process what follows --ros-args, where the command has that option, until left.

    `options.name` becomes the node's namespace, and the namespace the name.

    Raises:
        RosError: name and namespace contradict, or there is no node that takes the arguments.
    """
    ros_args = getattr(options, "ros_args", ())
    if getattr(options, "no_ros", False):
        _check_unneeded(ros_args)
    if ros_args and "name" in options:
        settle_name(options)
    give(node_arguments(ros_args, getattr(options, "name", "")) if ros_args else ())
    try:
        yield
    finally:
        give(())


def topic_remappings(ros_args: Sequence[str]) -> list[str]:
    """Returns the remappings of topics and services among the node's arguments, for others."""
    rules = [_NODE_IN_RULE.sub("", it) for flag, it in pairwise(ros_args) if flag in _REMAP]
    return [word for it in rules if not it.startswith("__") for word in ("-r", it)]


def node_name(ros_args: Sequence[str]) -> str:
    """Returns the name that the node has with these arguments, without its namespace."""
    return next((it[1] for word in ros_args if (it := _RENAMED.fullmatch(word))), _NODE)


def _check_unneeded(ros_args: Sequence[str]) -> None:
    """Refuses what only a node takes; launch files give every program a name and a namespace."""
    left = [it for it in ros_args if it not in _WITHOUT_VALUE and not _IDENTITY.match(it)]
    if left:
        raise RosError(
            f"--no-ros makes no node that takes {' '.join(left)}",
            hint="Leave out the one or the other; the configuration file has the same values.",
        )


def settle_name(options: argparse.Namespace) -> None:
    """Sets `options.name` to the node's namespace, where ROS's arguments give it instead of --name.

    Both are one identity: node, topics, frames, rows of /diagnostics and the announcement have it.

    Args:
        options: has name and ros_args.

    Raises:
        RosError: they give another one, or one of several parts.
    """
    nodes = None, node_name(options.ros_args)
    rules = [it for word in options.ros_args if (it := _NAMESPACE.fullmatch(word))]
    found = [it[2] for it in rules if it[1] in nodes]
    namespace = found[0].rstrip("/") if found else ""  # the first holds
    if not namespace:
        return
    if options.name not in ("", namespace):
        raise RosError(
            f"--name {options.name} and the namespace /{namespace} are of two receivers",
            hint=f"Leave one of them out, or write --name {namespace}.",
        )
    try:
        options.name = name(namespace)
    except argparse.ArgumentTypeError as error:
        raise RosError(
            f"the namespace /{namespace} cannot be a receiver's name: {error}",
            hint="Frame ids, topics and /diagnostics have it, too: choose one word.",
        ) from error


def node_arguments(ros_args: Sequence[str], namespace: str) -> list[str]:
    """The user's, and the namespace that the name is; empty for none."""
    remapping = ["-r", f"__ns:=/{namespace}"] if namespace else []
    return ["--ros-args", *ros_args, *remapping]
