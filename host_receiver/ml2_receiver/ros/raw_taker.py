"""Takes the bytes of many subscriptions in one thread.

rclpy's executors spend more on a message than everything else that is done with it; a bare wait
set does not.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, Protocol

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile

from ..errors import ReceiverError
from ..topics.message_types import message_class

_WAIT_NS = 100_000_000
# So much of a subscription is taken before it is another one's turn: one image, or many small
# messages. Counted alike, images would hold back samples of an IMU whenever some have queued.
_MOST_BYTES_IN_TURN = 1 << 16
_MOST_IN_TURN = 100
_SERVING: tuple[Literal["client", "service"], ...] = ("client", "service")


class Taking(Protocol):
    """A subscription; `take` gets CDR payloads, and what ROS knows of each."""

    @property
    def type(self) -> str: ...
    @property
    def topic(self) -> str: ...
    @property
    def qos(self) -> QoSProfile: ...
    def take(self, payload: bytes, info: Mapping[str, int]) -> None: ...


@dataclass(frozen=True)
class RawSubscription:
    """A subscription whose callback gets CDR payloads."""

    type: str
    topic: str
    qos: QoSProfile
    callback: Callable[[bytes], None]

    def take(self, payload: bytes, _: Mapping[str, int]) -> None:
        self.callback(payload)


class Serving(Protocol):
    """A client or a service of ROS, all in the taker's thread; `handle` is rclpy's."""

    @property
    def kind(self) -> Literal["client", "service"]: ...
    @property
    def topic(self) -> str: ...
    @property
    def handle(self) -> Any: ...
    def begin(self, node: Node) -> None: ...
    def work(self, *, is_ready: bool) -> None:
        """Does what there is to do, several times per second; `is_ready` if ROS has anything."""

    def end(self, node: Node) -> None: ...


class RawTaker:
    """Subscribes through a node that nobody spins; calls back on its own thread until stopped.

    Args:
        failed: gets the topics that cannot be subscribed to, and the messages for which a callback
            raises an exception. They do not end the thread, unless it is a ReceiverError.
        pause_s: after each turn of taking. What comes meanwhile is taken in one turn, for less CPU
            time; what a subscription has no depth for is left out.

    Attributes:
        failure: the ReceiverError that has ended the thread; None without one.
    """

    def __init__(
        self,
        node: Node,
        subscriptions: Sequence[Taking],
        failed: Callable[[str, Exception], None],
        pause_s: float = 0,
    ) -> None:
        self._node, self._pause_s, self._failed = node, pause_s, failed
        self.failure: ReceiverError | None = None
        self._taken: list[tuple[Taking, Any]] = []
        self._serving: list[Serving] = []
        # The node and its wait set are not thread-safe: only the thread changes them.
        self._changes: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._has_changes = _rclpy.GuardCondition(node.context.handle)
        for wanted in subscriptions:
            self._add(wanted)
        self._is_stopped = False
        self._thread = threading.Thread(target=self._run, name="raw-taker")
        self._thread.start()

    def add(self, wanted: Taking) -> None:
        """Subscribes to one more topic, soon. Thread-safe."""
        self._change(partial(self._try, wanted.topic, partial(self._add, wanted)))

    def remove(self, subscription: Taking) -> None:
        """Ends a subscription that was added, soon. Thread-safe."""
        self._change(partial(self._remove, subscription))

    def replace(self, old: Taking, new: Taking) -> None:
        """Ends a subscription once another one has taken its place. Thread-safe."""
        self.add(new)
        self._change(partial(self._take_last, old))

    def serve(self, wanted: Serving) -> None:
        """Begins a client or service, soon. Thread-safe."""
        self._change(partial(self._try, wanted.topic, partial(self._begin, wanted)))

    def end(self, serving: Serving) -> None:
        """Ends a client or service, soon. Thread-safe."""
        self._change(partial(self._try, serving.topic, partial(self._end, serving)))

    def _begin(self, wanted: Serving) -> None:
        wanted.begin(self._node)
        self._serving.append(wanted)

    def _end(self, serving: Serving) -> None:
        if serving in self._serving:
            self._serving.remove(serving)
            serving.end(self._node)

    def _change(self, change: Callable[[], None]) -> None:
        self._changes.put(change)
        self.wake()

    def wake(self) -> None:
        """Lets what is served work at once. Thread-safe."""
        with self._has_changes:
            self._has_changes.trigger_guard_condition()

    @property
    def is_alive(self) -> bool:
        """True while the thread runs; False after it was stopped or failed."""
        return self._thread.is_alive()

    def stop(self) -> None:
        """Ends the thread; the node may be destroyed afterwards."""
        self._is_stopped = True
        self._thread.join()

    def _add(self, wanted: Taking) -> None:
        made = self._node.create_subscription(
            message_class(wanted.type), wanted.topic, lambda _: None, wanted.qos, raw=True
        )
        # If Ctrl-C interrupts stop(), the node is destroyed while ROS waits for its subscriptions.
        # rclpy does not destroy a subscription before its last user has left it.
        made.handle.__enter__()
        self._taken.append((wanted, made))

    def _take_last(self, subscription: Taking) -> None:
        for wanted, made in self._taken:
            if wanted is subscription:
                self._take(wanted, made, wanted.qos.depth)
        self._remove(subscription)

    def _remove(self, subscription: Taking) -> None:
        for wanted, made in self._taken:
            if wanted is subscription:
                made.handle.__exit__(None, None, None)
                self._node.destroy_subscription(made)
        self._taken = [it for it in self._taken if it[0] is not subscription]

    def _try(self, topic: str, task: Callable[[], None]) -> None:
        try:
            task()
        except ReceiverError:
            raise
        except Exception as error:  # of what any node may publish
            self._failed(topic, error)

    def _run(self) -> None:
        try:
            self._take_until_stopped()
        except ReceiverError as error:
            self.failure = error
        finally:
            for _, made in self._taken:
                made.handle.__exit__(None, None, None)

    def _take_until_stopped(self) -> None:
        sizes = (-1, 0, 0)
        wait_set: Any = None
        # Ctrl-C may end the main thread before it can stop this one.
        while not self._is_stopped and threading.main_thread().is_alive():
            with suppress(queue.Empty):
                while True:
                    self._changes.get_nowait()()
            if sizes != self._sizes():
                sizes = subscriptions, clients, services = self._sizes()
                context = self._node.context.handle
                wait_set = _rclpy.WaitSet(subscriptions, 1, 0, clients, services, 0, context)
            self._wait(wait_set)
            self._work(wait_set)
            if self._pause_s:
                time.sleep(self._pause_s)

    def _sizes(self) -> tuple[int, int, int]:
        clients = sum(it.kind == "client" for it in self._serving)
        return len(self._taken), clients, len(self._serving) - clients

    def _wait(self, wait_set: Any) -> None:
        wait_set.clear_entities()
        wait_set.add_guard_condition(self._has_changes)
        for _, subscription in self._taken:
            wait_set.add_subscription(subscription.handle)
        for serving in self._serving:
            add = wait_set.add_client if serving.kind == "client" else wait_set.add_service
            add(serving.handle)
        wait_set.wait(_WAIT_NS)

    def _work(self, wait_set: Any) -> None:
        ready = set(wait_set.get_ready_entities("subscription"))
        for wanted, subscription in self._taken:
            if subscription.handle.pointer in ready:
                self._take_in_turn(wanted, subscription)
        if not self._serving:
            return
        ready = {it for kind in _SERVING for it in wait_set.get_ready_entities(kind)}
        for serving in self._serving:
            is_ready = serving.handle.pointer in ready
            self._try(serving.topic, partial(serving.work, is_ready=is_ready))

    def _take_in_turn(self, wanted: Taking, subscription: Any) -> None:
        if self._pause_s:
            self._take(wanted, subscription, wanted.qos.depth)
        else:
            self._take(wanted, subscription, _MOST_IN_TURN, _MOST_BYTES_IN_TURN)

    def _take(
        self, wanted: Taking, subscription: Any, most: int, most_bytes: float = float("inf")
    ) -> None:
        taken_bytes = 0
        for _ in range(most):
            taken = subscription.handle.take_message(subscription.msg_type, True)
            if taken is None:
                return
            self._try(wanted.topic, partial(wanted.take, *taken))
            taken_bytes += len(taken[0])
            if taken_bytes >= most_bytes:
                return
