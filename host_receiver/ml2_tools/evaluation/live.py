"""Records one camera and the transforms of a running receiver for a later evaluation."""

import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from rclpy.qos import DurabilityPolicy, QoSProfile

from ml2_receiver.recording.bag_topic import BagTopic
from ml2_receiver.recording.bag_writer import BagWriter
from ml2_receiver.ros.context import count_publishers, tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_receiver.table.stream_table import Qos

from ..errors import EvaluationError
from ..geometry.transform_tree import STATIC_DEPTH
from ..images.image_topic import image_topics
from ..live.faults import Faults
from .sequence import Parts, Sequence

_IMAGES_DEPTH = 60
_TRANSFORMS_DEPTH = 1000
_PATIENCE_S = 10.0
_POLL_S = 0.2
_STATIC_TRANSFORMS = "/tf_static"


def record_live(
    prefix: str,
    camera: str,
    folder: Path,
    stopping: threading.Event,
    report: Callable[[int], None],
) -> Sequence:
    """Records into `folder` until `stopping` is set.

    Args:
        prefix: the prefix of the topics, such as /magic_leap2.
        camera: the camera's stream, such as world_center.
        folder: an empty folder; it must exist for as long as the sequence is used.
        report: is called a few times per second with the number of images recorded so far.

    Raises:
        EvaluationError: no messages arrive, or too few to evaluate.
        RosError: ROS does not start.
    """
    with tool_node("ml2_evaluate") as node:
        exists = partial(count_publishers, node)
        names = [topic.full_name(prefix) for topic in image_topics(camera)]
        missing = f"no camera_info and metadata of {prefix}/{camera} arrived"
        _await(lambda: any(map(exists, names)), missing, stopping)
        parts = Parts(prefix, camera, exists)
        writer = BagWriter(folder, "none")
        topics = {name: BagTopic(name, type, Qos(1)) for name, type in parts.types.items()}
        for topic in topics.values():
            writer.add_topic(topic)

        def take(name: str, payload: bytes) -> None:
            parts.take(name, payload)
            writer.write(topics[name], time.time_ns(), payload)

        taker = RawTaker(
            node,
            [
                RawSubscription(type, name, _qos(name), partial(take, name))
                for name, type in parts.types.items()
            ],
            Faults().add,
        )
        try:
            _await(lambda: parts.camera() is not None, missing, stopping)
            while not stopping.wait(_POLL_S) and taker.is_alive:
                report(parts.images_taken)
        finally:
            taker.stop()
            writer.close()
        if taker.failure is not None:
            raise taker.failure
        return parts.sequence(folder)


def _await(is_there: Callable[[], bool], missing: str, stopping: threading.Event) -> None:
    deadline_s = time.monotonic() + _PATIENCE_S
    while not is_there() and not stopping.is_set():
        if time.monotonic() > deadline_s:
            raise EvaluationError(
                f"{missing} within {_PATIENCE_S:g} s; "
                "is `ml2-receiver run` running, with a headset?"
            )
        stopping.wait(_POLL_S)


def _qos(topic: str) -> QoSProfile:
    if topic == _STATIC_TRANSFORMS:
        return QoSProfile(depth=STATIC_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    return QoSProfile(depth=_TRANSFORMS_DEPTH if topic == "/tf" else _IMAGES_DEPTH)
