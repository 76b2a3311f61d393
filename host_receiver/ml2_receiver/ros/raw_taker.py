"""Takes the bytes of many subscriptions in one thread.

rclpy's executors spend more on a message than everything else that is done with it; a bare wait
set does not.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile

from ..topics.message_types import message_class

_WAIT_NS = 100_000_000


@dataclass(frozen=True)
class RawSubscription:
    """A subscription whose callback gets CDR payloads."""

    type: str
    topic: str
    qos: QoSProfile
    callback: Callable[[bytes], None]


class RawTaker:
    """Subscribes through a node that nobody spins; calls back on its own thread until stopped."""

    def __init__(self, node: Node, subscriptions: list[RawSubscription]) -> None:
        self._node = node
        self._handles: list[tuple[Any, Any, Callable[[bytes], None]]] = []
        for wanted in subscriptions:
            self.add(wanted)
        self._is_stopped = False
        self._thread = threading.Thread(target=self._run, name="raw-taker")
        self._thread.start()

    def add(self, wanted: RawSubscription) -> None:
        """One more; once the thread runs, only a callback may."""
        made = self._node.create_subscription(
            message_class(wanted.type), wanted.topic, wanted.callback, wanted.qos, raw=True
        )
        self._handles.append((made.handle, made.msg_type, wanted.callback))

    @property
    def is_alive(self) -> bool:
        """True while the thread runs; False after it was stopped or failed."""
        return self._thread.is_alive()

    def stop(self) -> None:
        """Ends the thread; the node may be destroyed afterwards."""
        self._is_stopped = True
        self._thread.join()

    def _run(self) -> None:
        size = 0
        wait_set: Any = None
        while not self._is_stopped:
            if size != len(self._handles):
                size = len(self._handles)
                wait_set = _rclpy.WaitSet(size, 0, 0, 0, 0, 0, self._node.context.handle)
            wait_set.clear_entities()
            for handle, _, _ in self._handles:
                wait_set.add_subscription(handle)
            wait_set.wait(_WAIT_NS)
            self._take(set(wait_set.get_ready_entities("subscription")))

    def _take(self, ready: set[int]) -> None:
        for handle, message_type, callback in self._handles:
            if handle.pointer not in ready:
                continue
            while (taken := handle.take_message(message_type, True)) is not None:
                callback(taken[0])
