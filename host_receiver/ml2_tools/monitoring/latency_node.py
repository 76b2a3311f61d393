"""The ROS node of `ml2-receiver latency`; with raw_taker the only one beside ros to use rclpy."""

import threading
import time
from collections.abc import Mapping
from contextlib import suppress

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message

from ml2_receiver.errors import RosError
from ml2_receiver.ros.context import start_ros
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_receiver.topics.stamps import stamp_reader
from ml2_receiver.topics.status_name import split_status_name

from .latency import Breakdown, TopicLatency

# As many as a window has: on a busy machine this subscriber is late, which it is to show, and must
# not lose messages instead. Only those that wait take memory.
_DEPTH = 512


class LatencyNode:
    """The node `ml2_latency`: subscribes to every topic that /diagnostics of a receiver names.

    One thread takes, and any may ask. close() ends it.

    Args:
        receiver: as in its --name, or empty.
        windows: see TopicLatency.

    Raises:
        RosError: ROS does not start.
    """

    def __init__(self, receiver: str, windows: int) -> None:
        self._receiver, self._windows = receiver, windows
        self._lock = threading.Lock()
        self._topics: dict[str, TopicLatency] = {}
        self._session: Mapping[str, str] = {}
        self._context = start_ros()
        self._node = rclpy.create_node("ml2_latency", context=self._context)
        type = "diagnostic_msgs/msg/DiagnosticArray"
        rows = RawSubscription(type, "/diagnostics", QoSProfile(depth=_DEPTH), self._diagnosed)
        with self._lock:  # who is diagnosed at once needs the taker
            self._taker = RawTaker(self._node, [rows])

    def close(self) -> None:
        """Ends the node; nothing may be called after."""
        self._taker.stop()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    @property
    def session_state(self) -> str | None:
        """As /diagnostics has it; None without a receiver."""
        with self._lock:
            return self._session.get("state")

    def breakdowns(self) -> dict[str, tuple[str, Breakdown | None]]:
        """By topic, the stream it belongs to and where its time goes.

        Raises:
            RosError: the thread that takes has failed; its traceback is on stderr.
        """
        if not self._taker.is_alive:
            raise RosError("the messages of the receiver cannot be taken")
        with self._lock:
            return {name: (it.stream, it.breakdown()) for name, it in self._topics.items()}

    def _diagnosed(self, payload: bytes) -> None:
        for status in deserialize_message(payload, DiagnosticArray).status:
            receiver, name = split_status_name(status.name) or (None, "")
            if receiver != self._receiver:
                continue
            values = {pair.key: pair.value for pair in status.values}
            with self._lock:
                if name == "session":
                    self._session = values
                elif "type" in values:
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
            with suppress(ValueError), self._lock:  # what has no stamp has no latency
                topic.arrived(read_stamp(payload), now_ns)

        self._taker.add(RawSubscription(values["type"], name, QoSProfile(depth=_DEPTH), take))
