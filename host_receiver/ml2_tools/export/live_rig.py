"""One look at the cameras, transforms and an IMU that a receiver publishes now."""

from __future__ import annotations

import json
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Imu
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from ml2_receiver.errors import ExportError
from ml2_receiver.ros.context import start_ros
from ml2_receiver.table.reader import load_table

from ..geometry.pose import Pose
from ..geometry.transform_tree import STATIC_DEPTH, Tree
from .kalibr import CAMERAS, RigCamera
from .rig import Rig, calibration_of

_IMU_MESSAGES = 100
_STAMPS = 256
_WAIT_S = 0.1


def look(prefix: str, cameras: Sequence[str], imu: str | None, timeout_s: float) -> Rig:
    """Waits for what is asked for, at most `timeout_s`.

    Args:
        cameras: ids of streams; none means those of CAMERAS that run.
        imu: of which stream to measure the rate, if of any.

    Raises:
        ExportError: something does not come; says what.
        RosError: ROS does not start.
    """
    context = start_ros()
    executor = SingleThreadedExecutor(context=context)
    observer = _Observer(prefix, context)
    executor.add_node(observer.node)
    deadline_s = time.monotonic() + timeout_s

    def until(is_there: Callable[[], Any], missing: str) -> None:
        while not is_there():
            if time.monotonic() > deadline_s:
                raise ExportError(f"{missing} within {timeout_s:g} s")
            executor.spin_once(timeout_sec=_WAIT_S)

    try:
        if not cameras:
            until(lambda: observer.running, f"no camera of {', '.join(CAMERAS)} under {prefix}")
            cameras = observer.running
        observer.watch(cameras, imu)
        wanted = set(cameras)
        missing = f"not every camera_info of {', '.join(cameras)} under {prefix}"
        until(lambda: wanted <= observer.infos.keys(), missing)
        if len(cameras) > 1:
            frames = {observer.infos[camera].header.frame_id: camera for camera in cameras}
            observer.follow(frames)
            missing = f"no instant with transforms of {', '.join(sorted(frames))}"
            until(lambda: observer.poses, missing)
        if imu is not None:
            until(lambda: len(observer.imu_s) >= _IMU_MESSAGES, f"no {prefix}/{imu}/imu")
        return observer.rig(cameras)
    finally:
        executor.shutdown()
        observer.node.destroy_node()
        rclpy.shutdown(context=context)


class _Observer:
    """What comes of one receiver.

    Attributes:
        poses: of all cameras by id, at the latest instant that has them all; empty before it.
    """

    def __init__(self, prefix: str, context: Context) -> None:
        self.node = rclpy.create_node("ml2_export", context=context)
        self.running: tuple[str, ...] = ()
        self.infos: dict[str, CameraInfo] = {}
        self.imu_s: set[float] = set()
        self.poses: dict[str, Pose] = {}
        self._prefix = prefix
        self._tree: Tree
        self._count = 0
        self._instants: OrderedDict[int, dict[str, Pose]] = OrderedDict()
        latched = QoSProfile(
            depth=1,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
            reliability=ReliabilityPolicy.RELIABLE,
        )
        self.node.create_subscription(String, f"{prefix}/config", self._configured, latched)

    def watch(self, cameras: Sequence[str], imu: str | None) -> None:
        for camera in cameras:
            topic = f"{self._prefix}/{camera}/camera_info"
            self.node.create_subscription(CameraInfo, topic, self._info_taker(camera), 5)
        if imu is not None:
            self.node.create_subscription(Imu, f"{self._prefix}/{imu}/imu", self._measured, 200)

    def follow(self, frames: Mapping[str, str]) -> None:
        """Looks for `poses` of the cameras that have these optical frames."""
        self._tree, self._count = Tree.of(frames), len(frames)
        static = QoSProfile(depth=STATIC_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(TFMessage, "/tf_static", self._stood, static)
        self.node.create_subscription(TFMessage, "/tf", self._transformed, 100)

    def rig(self, cameras: Sequence[str]) -> Rig:
        topics = {camera: load_table().streams[camera].topics[0] for camera in cameras}
        rate_hz = None
        if self.imu_s:
            rate_hz = (len(self.imu_s) - 1) / (max(self.imu_s) - min(self.imu_s))
        return Rig(
            tuple(
                RigCamera(
                    topics[camera].full_name(self._prefix),
                    calibration_of(self.infos[camera]),
                    # A single camera is nowhere in particular.
                    self.poses.get(camera, np.eye(4)),
                )
                for camera in cameras
            ),
            rate_hz,
        )

    def _configured(self, message: String) -> None:
        try:
            streams = json.loads(message.data)["streams"]
            self.running = tuple(it for it in CAMERAS if streams.get(it, {}).get("topics"))
        except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
            raise ExportError(f"{self._prefix}/config is not as a receiver writes it") from error

    def _info_taker(self, camera: str) -> Callable[[CameraInfo], None]:
        return lambda message: self.infos.update({camera: message})

    def _measured(self, message: Imu) -> None:
        self.imu_s.add(message.header.stamp.sec + message.header.stamp.nanosec * 1e-9)

    def _stood(self, message: TFMessage) -> None:
        try:
            self._tree.stand(message)
        except ValueError as error:
            raise ExportError(f"/tf_static: {error}") from error

    def _transformed(self, message: TFMessage) -> None:
        try:
            for camera, stamp_ns, pose in self._tree.poses(message):
                instant = self._instants.setdefault(stamp_ns, {})
                instant[camera] = pose
                if len(instant) == self._count:
                    self.poses = instant
        except ValueError as error:
            raise ExportError(f"/tf: {error}") from error
        while len(self._instants) > _STAMPS:
            self._instants.popitem(last=False)
