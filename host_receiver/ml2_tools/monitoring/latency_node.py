"""The ROS node of `ml2-receiver latency`."""

import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack, suppress

from rclpy.qos import QoSProfile

from ml2_receiver.errors import RosError
from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_receiver.topics.stamps import stamp_reader

from ..live.diagnostics import TYPE, Diagnosed, read_diagnostics
from ..live.faults import Faults
from .latency import Breakdown, TopicLatency

# As many messages as a window has. On a busy machine this subscriber must show the delay and not
# lose messages instead. Only waiting messages take memory.
_DEPTH = 512


class LatencyNode:
    """The node `ml2_latency`: subscribes to every topic that a receiver lists in /diagnostics.

    Thread-safe. An own thread takes the messages until close().

    Args:
        receiver: the receiver's --name, or empty.
        windows: see TopicLatency.

    Raises:
        RosError: ROS does not start.
    """

    def __init__(self, receiver: str, windows: int) -> None:
        self._receiver, self._windows = receiver, windows
        self._lock = threading.Lock()
        self._topics: dict[str, TopicLatency] = {}
        self._session: Mapping[str, str] = {}
        self._closing = ExitStack()
        node = self._closing.enter_context(tool_node("ml2_latency"))
        rows = RawSubscription(
            TYPE, "/diagnostics", QoSProfile(depth=_DEPTH), self._take_diagnostics
        )
        with self._lock:  # _take_diagnostics() needs _taker, and may be called at once
            self._taker = RawTaker(node, [rows], Faults().add)
        self._closing.callback(self._taker.stop)

    def close(self) -> None:
        """Ends the node; no method may be called afterwards."""
        self._closing.close()

    @property
    def session_state(self) -> str | None:
        """The session's state in /diagnostics; None without a receiver."""
        with self._lock:
            return self._session.get("state")

    def breakdowns(self) -> dict[str, tuple[str, Breakdown | None]]:
        """Returns the stream and the latency by stage of each topic.

        Raises:
            RosError: the thread that takes messages has failed.
        """
        if not self._taker.is_alive:
            raise self._taker.failure or RosError("the thread that takes messages has failed")
        with self._lock:
            return {name: (it.stream, it.breakdown()) for name, it in self._topics.items()}

    def _take_diagnostics(self, payload: bytes) -> None:
        found = read_diagnostics(payload).get(self._receiver, Diagnosed())
        with self._lock:
            self._session = found.rows.get("session", self._session)
            for name, values in found.rows.items():
                if "type" in values and "stream" in values:
                    self._topic(name, values).reported(values)

    def _topic(self, name: str, values: Mapping[str, str]) -> TopicLatency:
        topic = self._topics.get(name)
        if topic is None:
            topic = self._topics[name] = TopicLatency(values["stream"], self._windows)
            self._subscribe(name, values, topic)
        return topic

    def _subscribe(self, name: str, values: Mapping[str, str], topic: TopicLatency) -> None:
        read_stamp = stamp_reader(values["type"])

        def take(payload: bytes) -> None:
            now_ns = time.time_ns()
            with suppress(ValueError), self._lock:  # a message without a stamp has no latency
                topic.arrived(read_stamp(payload), now_ns)

        self._taker.add(RawSubscription(values["type"], name, QoSProfile(depth=_DEPTH), take))
