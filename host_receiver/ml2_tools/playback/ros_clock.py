"""Publishes the time of a played recording for ROS nodes with `use_sim_time`."""

import threading
from typing import Self

from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock

from ml2_receiver.ros.context import end_node, start_node_named

from ..errors import PlaybackError
from .timeline import Timeline

_PERIOD_S = 0.01
_NANOS_PER_SECOND = 1_000_000_000
LAST_NS = (1 << 31) * _NANOS_PER_SECOND - 1  # of builtin_interfaces/Time, in the year 2038


class RosClock:
    """Publishes a timeline on /clock 100 times per second; a context manager.

    As with `ros2 bag play --clock`, the time is the recorded receive time of the messages. It does
    not advance while playing is paused.

    Raises:
        RosError: ROS does not start.
        PlaybackError: the timeline begins after the last time that ROS has.
    """

    def __init__(self, timeline: Timeline) -> None:
        if timeline.now_ns() > LAST_NS:
            raise PlaybackError(
                f"ROS has times up to {LAST_NS} ns, but the recording begins at"
                f" {timeline.now_ns()} ns",
                hint="Leave out --clock.",
            )
        self._timeline = timeline
        self._node = start_node_named("ml2_play")
        self._publisher = self._node.create_publisher(Clock, "/clock", 1)
        self._leaving = threading.Event()
        self._thread = threading.Thread(target=self._publish, name="clock")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._leaving.set()
        self._thread.join()
        end_node(self._node)

    def _publish(self) -> None:
        while not self._leaving.wait(_PERIOD_S):
            sec, nanosec = divmod(min(self._timeline.now_ns(), LAST_NS), _NANOS_PER_SECOND)
            self._publisher.publish(Clock(clock=Time(sec=sec, nanosec=nanosec)))
