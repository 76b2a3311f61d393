"""Takes the bytes of many subscriptions in one thread.

rclpy's executors spend more on a message than everything else that is done with it; a bare wait
set does not.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile

from ml2_receiver.errors import ReceiverError
from ml2_receiver.topics.message_types import message_class

from .faults import Faults

_WAIT_NS = 100_000_000


@dataclass(frozen=True)
class RawSubscription:
    """A subscription whose callback gets CDR payloads."""

    type: str
    topic: str
    qos: QoSProfile
    callback: Callable[[bytes], None]


class RawTaker:
    """Subscribes through a node that nobody spins; calls back on its own thread until stopped.

    Args:
        pause_s: after each turn of taking. What comes meanwhile is taken in one turn, for less CPU
            time; what a subscription has no depth for is left out.
        faults: gets the topics that cannot be subscribed to, and the messages for which a callback
            raises an exception. They do not end the thread, unless it is a ReceiverError.

    Attributes:
        failure: the ReceiverError that has ended the thread; None without one.
    """

    def __init__(
        self,
        node: Node,
        subscriptions: list[RawSubscription],
        pause_s: float = 0,
        faults: Faults | None = None,
    ) -> None:
        self._node, self._pause_s = node, pause_s
        self._faults = faults or Faults()
        self.failure: ReceiverError | None = None
        self._taken: list[tuple[RawSubscription, Any]] = []
        # The node and its wait set are not thread-safe: only the thread changes them.
        self._changes: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        for wanted in subscriptions:
            self._add(wanted)
        self._is_stopped = False
        self._thread = threading.Thread(target=self._run, name="raw-taker")
        self._thread.start()

    def add(self, wanted: RawSubscription) -> None:
        """Subscribes to one more topic, within 0.1 s. Thread-safe."""
        self._changes.put(partial(self._try, wanted.topic, partial(self._add, wanted)))

    def remove(self, subscription: RawSubscription) -> None:
        """Ends a subscription that was added, within 0.1 s. Thread-safe."""
        self._changes.put(partial(self._remove, subscription))

    @property
    def is_alive(self) -> bool:
        """True while the thread runs; False after it was stopped or failed."""
        return self._thread.is_alive()

    def stop(self) -> None:
        """Ends the thread; the node may be destroyed afterwards."""
        self._is_stopped = True
        self._thread.join()

    def _add(self, wanted: RawSubscription) -> None:
        made = self._node.create_subscription(
            message_class(wanted.type), wanted.topic, wanted.callback, wanted.qos, raw=True
        )
        self._taken.append((wanted, made))

    def _remove(self, subscription: RawSubscription) -> None:
        for wanted, made in self._taken:
            if wanted is subscription:
                self._node.destroy_subscription(made)
        self._taken = [it for it in self._taken if it[0] is not subscription]

    def _try(self, topic: str, task: Callable[[], None]) -> None:
        try:
            task()
        except ReceiverError:
            raise
        except Exception as error:  # of what any node may publish
            self._faults.add(topic, error)

    def _run(self) -> None:
        try:
            self._take_until_stopped()
        except ReceiverError as error:
            self.failure = error

    def _take_until_stopped(self) -> None:
        size = 0
        wait_set: Any = None
        while not self._is_stopped:
            with suppress(queue.Empty):
                while True:
                    self._changes.get_nowait()()
            if size != len(self._taken):
                size = len(self._taken)
                wait_set = _rclpy.WaitSet(size, 0, 0, 0, 0, 0, self._node.context.handle)
            wait_set.clear_entities()
            for _, subscription in self._taken:
                wait_set.add_subscription(subscription.handle)
            wait_set.wait(_WAIT_NS)
            self._take(set(wait_set.get_ready_entities("subscription")))
            if self._pause_s:
                time.sleep(self._pause_s)

    def _take(self, ready: set[int]) -> None:
        for wanted, subscription in self._taken:
            handle = subscription.handle
            if handle.pointer not in ready:
                continue
            while (taken := handle.take_message(subscription.msg_type, True)) is not None:
                self._try(wanted.topic, partial(wanted.callback, taken[0]))
