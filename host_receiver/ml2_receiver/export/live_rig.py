"""One look at the cameras, transforms and an IMU that a receiver publishes now."""

from __future__ import annotations

import json
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Imu
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from ..configuration.table import load_table
from ..errors import ExportError
from ..ros_context import start_ros
from .kalibr import CAMERAS, RigCamera
from .pose import Pose, pose_of
from .rig import Rig, calibration_of

_IMU_MESSAGES = 100
_STAMPS = 256
_WAIT_S = 0.1


def look(prefix: str, cameras: Sequence[str], imu: str | None, patience_s: float) -> Rig:
    """Waits for what is asked for, at most `patience_s`.

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
    deadline_s = time.monotonic() + patience_s

    def until(is_there: Callable[[], Any], missing: str) -> None:
        while not is_there():
            if time.monotonic() > deadline_s:
                raise ExportError(f"{missing} within {patience_s:g} s")
            executor.spin_once(timeout_sec=_WAIT_S)

    try:
        if not cameras:
            until(lambda: observer.running, f"no camera of {', '.join(CAMERAS)} under {prefix}")
            cameras = observer.running
        observer.watch(cameras, imu)
        wanted = set(cameras)
        missing = f"not every camera_info of {', '.join(cameras)} under {prefix}"
        until(lambda: wanted <= observer.infos.keys(), missing)
        frames = {observer.infos[camera].header.frame_id for camera in cameras}
        if len(cameras) > 1:
            missing = f"no instant with transforms of {', '.join(sorted(frames))}"
            until(lambda: observer.poses(frames), missing)
        if imu is not None:
            until(lambda: len(observer.imu_s) >= _IMU_MESSAGES, f"no {prefix}/{imu}/imu")
        return observer.rig(cameras, frames)
    finally:
        executor.shutdown()
        observer.node.destroy_node()
        rclpy.shutdown(context=context)


class _Observer:
    def __init__(self, prefix: str, context: Context) -> None:
        self.node = rclpy.create_node("ml2_export", context=context)
        self.running: tuple[str, ...] = ()
        self.infos: dict[str, CameraInfo] = {}
        self.imu_s: set[float] = set()
        self._prefix, self._world = prefix, load_table().world_frame
        self._poses: OrderedDict[tuple[int, int], dict[str, Pose]] = OrderedDict()
        latched = QoSProfile(
            depth=1,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
            reliability=ReliabilityPolicy.RELIABLE,
        )
        self.node.create_subscription(String, f"{prefix}/config", self._configured, latched)

    def watch(self, cameras: Sequence[str], imu: str | None) -> None:
        self.node.create_subscription(TFMessage, "/tf", self._transformed, 100)
        for camera in cameras:
            topic = f"{self._prefix}/{camera}/camera_info"
            self.node.create_subscription(CameraInfo, topic, self._info_taker(camera), 5)
        if imu is not None:
            self.node.create_subscription(Imu, f"{self._prefix}/{imu}/imu", self._measured, 200)

    def poses(self, frames: set[str]) -> dict[str, Pose]:
        """Those of the latest instant that has all of `frames`; empty if none has."""
        instants = (it for it in reversed(self._poses.values()) if frames <= it.keys())
        return next(instants, {})

    def rig(self, cameras: Sequence[str], frames: set[str]) -> Rig:
        poses = self.poses(frames)
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
                    poses.get(self.infos[camera].header.frame_id, np.eye(4)),
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

    def _transformed(self, message: TFMessage) -> None:
        for it in message.transforms:
            if not it.header.frame_id.endswith(self._world):
                continue
            stamp = it.header.stamp.sec, it.header.stamp.nanosec
            try:
                self._poses.setdefault(stamp, {})[it.child_frame_id] = pose_of(it.transform)
            except ValueError as error:
                raise ExportError(f"/tf, {it.child_frame_id}: {error}") from error
            if len(self._poses) > _STAMPS:
                self._poses.popitem(last=False)
