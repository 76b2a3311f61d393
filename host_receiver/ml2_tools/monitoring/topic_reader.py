"""Reads the messages of one topic and formats them as text."""

import array
import threading
import time
from collections.abc import Callable, Iterator
from difflib import get_close_matches
from typing import Any

import numpy as np
import yaml
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ml2_receiver.errors import RosError
from ml2_receiver.printable import printable
from ml2_receiver.ros.context import tool_node
from ml2_receiver.topics.message_types import message_class

_WAIT_S = 0.1
_DEPTH = 10
_MOST_ELEMENTS = 16
_MOST_CHARACTERS = 64 * 1024  # a text may be JSON of all streams


def messages(
    topic: str, timeout_s: float, stopping: threading.Event, found: Callable[[], None]
) -> Iterator[Any]:
    """Yields the messages of a topic until `stopping` is set.

    Args:
        timeout_s: how long to wait for a publisher.
        found: is called when there is one.

    Raises:
        RosError: the topic has no publisher, or its type is not installed.
    """
    arrived: list[Any] = []
    with tool_node("ml2_echo") as node:
        executor = SingleThreadedExecutor(context=node.context)
        executor.add_node(node)
        try:
            type = _await_type(node, executor, topic, timeout_s, stopping)
            if type is None:
                return
            found()
            node.create_subscription(_class(type), topic, arrived.append, _qos(node, topic))
            while not stopping.is_set():
                executor.spin_once(timeout_sec=_WAIT_S)
                while arrived:
                    yield arrived.pop(0)
        finally:
            executor.shutdown()


def as_text(message: Any) -> str:
    """Formats a message as YAML; of a long array, only the first elements and their number."""
    return yaml.safe_dump(
        _plain(message),
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=None,
        width=float("inf"),
    )


def _await_type(
    node: Node,
    executor: SingleThreadedExecutor,
    topic: str,
    timeout_s: float,
    stopping: threading.Event,
) -> str | None:
    """Waits for a publisher; returns the topic's type, or None if `stopping` is set first."""
    deadline_s = time.monotonic() + timeout_s
    name = node.resolve_topic_name(topic)
    types: dict[str, list[str]] = {}
    while time.monotonic() < deadline_s:
        if stopping.is_set():
            return None
        types = dict(node.get_topic_names_and_types())
        if name in types and node.count_publishers(name):
            return str(types[name][0])
        executor.spin_once(timeout_sec=_WAIT_S)
    close = get_close_matches(name, types.keys() - {name}, 1, cutoff=0.8)
    meant = f"; did you mean {printable(close[0])}?" if close else ""
    raise RosError(
        f"{topic} has no publisher after {timeout_s:g} s{meant}",
        hint="`ml2-receiver topics` lists the topics of a running receiver.",
    )


def _class(type: str) -> Any:
    try:
        return message_class(type)
    except ImportError as error:
        raise RosError(f"a topic of the type {type} cannot be shown: {error}") from error


def _qos(node: Node, name: str) -> QoSProfile:
    """Returns a QoS profile that is compatible with all publishers of a topic."""
    offered = [it.qos_profile for it in node.get_publishers_info_by_topic(name)]
    is_latched = all(it.durability == DurabilityPolicy.TRANSIENT_LOCAL for it in offered)
    is_reliable = all(it.reliability == ReliabilityPolicy.RELIABLE for it in offered)
    return QoSProfile(
        depth=_DEPTH,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
    )


def _plain(value: Any) -> Any:
    if hasattr(value, "get_fields_and_field_types"):
        names = value.get_fields_and_field_types()
        return {name: _plain(getattr(value, name)) for name in names}
    if isinstance(value, str):
        return printable(value, _MOST_CHARACTERS, has_lines=True)
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, bytes | bytearray | array.array | np.ndarray | list | tuple):
        shown = [_plain(it) for it in value[:_MOST_ELEMENTS]]
        rest = [] if len(value) <= _MOST_ELEMENTS else [f"... {len(value)} in all"]
        return shown + rest
    return value
