"""A camera's trajectory from the images that a running receiver publishes now."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Self

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile

from ml2_receiver.errors import EvaluationError
from ml2_receiver.ros.context import start_ros
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker

from ..geometry.camera import Camera
from ..geometry.transform_tree import STATIC_DEPTH
from .estimator import Images, Trajectory
from .evaluation import Evaluation, estimator_named, judged
from .sequence import Parts, Sequence, grey_images

# Two seconds of images, for an estimator that stops to think.
_MOST_WAITING = 60
_TRANSFORMS_DEPTH = 1000
_PATIENCE_S = 10.0
_SILENCE_S = 3.0
_POLL_S = 0.1


def evaluate_live(
    prefix: str,
    camera: str,
    estimator: str,
    truth: Trajectory | None,
    watched: Callable[[Images], Images],
) -> tuple[Evaluation, int]:
    """Estimates while images come, and compares when there are no more.

    Args:
        watched: is given the images that the estimator is to read; ends them when it is told to.

    Returns:
        With it, how many images the estimator never saw, as it was too slow for them.

    Raises:
        EvaluationError: nothing comes, or what comes gives no trajectory.
        RosError: ROS does not start.
    """
    estimate = estimator_named(estimator)
    with LiveCamera(prefix, camera) as live:
        lens = live.camera()
        found = estimate(watched(live.images()), lens)
    return judged(live.sequence(), camera, estimator, found, truth), live.dropped


class LiveCamera:
    """One camera's topics and the transforms, taken by a thread of its own until it is left.

    Attributes:
        dropped: images that came while too many waited for the estimator.
    """

    def __init__(self, prefix: str, camera: str) -> None:
        self.dropped = 0
        self._parts = Parts(prefix, camera)
        self._topic = f"{prefix}/{camera}"
        self._waiting: queue.Queue[bytes] = queue.Queue(_MOST_WAITING)
        self._context = start_ros()
        self._node = rclpy.create_node("ml2_evaluate", context=self._context)
        subscriptions = [
            RawSubscription(type, topic, _qos(topic), partial(self._take, topic))
            for topic, type in self._parts.types.items()
        ]
        self._taker = RawTaker(self._node, subscriptions)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: object, trace: TracebackType | None
    ) -> None:
        self._taker.stop()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    def camera(self) -> Camera:
        """The lens, once a camera_info and its metadata have come.

        Raises:
            EvaluationError: they do not come.
        """
        deadline_s = time.monotonic() + _PATIENCE_S
        while (camera := self._parts.camera()) is None:
            if time.monotonic() > deadline_s:
                missing = f"no camera_info and metadata of {self._topic} within {_PATIENCE_S:g} s"
                raise EvaluationError(f"{missing}: is `ml2-receiver run` running, with a headset?")
            time.sleep(_POLL_S)
        return camera

    def images(self) -> Images:
        """As they come, until none comes for a while.

        Raises:
            EvaluationError: a message is no image, or stamps do not rise.
        """
        topic = self._parts.image
        return grey_images(self._payloads(), self._parts.types[topic], topic)

    def sequence(self) -> Sequence:
        """Of all that came; after this camera was left.

        Raises:
            EvaluationError: it is not enough.
        """
        return self._parts.sequence(Path("live"))

    def _payloads(self) -> Iterator[bytes]:
        try:
            while True:
                yield self._waiting.get(timeout=_SILENCE_S)
        except queue.Empty:
            return

    def _take(self, topic: str, payload: bytes) -> None:
        self._parts.take(topic, payload)
        if topic == self._parts.image:
            try:
                self._waiting.put_nowait(payload)
            except queue.Full:
                self.dropped += 1


def _qos(topic: str) -> QoSProfile:
    if topic == "/tf_static":
        return QoSProfile(depth=STATIC_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    return QoSProfile(depth=_TRANSFORMS_DEPTH if topic == "/tf" else _MOST_WAITING)
