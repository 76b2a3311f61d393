"""Reads the cameras, transforms and an IMU that a running receiver publishes."""

import json
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, Imu
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from ml2_receiver.ros.context import count_publishers, end_node, start_node_named
from ml2_receiver.topics.stamps import header_stamp_ns

from ..errors import ExportError
from ..geometry.pose import Pose
from ..geometry.transform_tree import STATIC_DEPTH, Tree
from ..images.image_topic import image_topic
from .kalibr import CAMERAS, Mounting, RigCamera
from .rig import Rig, calibration_of, head_in, rate_hz

_IMU_MESSAGES = 100
_STAMPS = 256
# Poses of the head and of the camera are at different times: their difference is a mean of so many.
_MEAN_OF = 30
_WAIT_S = 0.1


def read_live_rig(
    prefix: str,
    cameras: Sequence[str],
    imu: str | None,
    mounting_of: Callable[[str], Mounting | None],
    timeout_s: float,
) -> Rig:
    """Waits up to `timeout_s` for the messages of the cameras and the IMU.

    Args:
        cameras: stream ids; if empty, the cameras of CAMERAS that run.
        imu: the stream id of the IMU whose rate is measured, or None.
        mounting_of: returns the IMU's mounting in the head for the id of a device, if it is known.

    Raises:
        ExportError: messages do not arrive in time; the error names them.
        RosError: ROS does not start.
    """
    observer = _Observer(prefix)
    executor = SingleThreadedExecutor(context=observer.node.context)
    executor.add_node(observer.node)
    deadline_s = time.monotonic() + timeout_s

    def wait_until(has_arrived: Callable[[], Any], missing: str) -> None:
        while not has_arrived():
            if time.monotonic() > deadline_s:
                raise ExportError(f"{missing} within {timeout_s:g} s")
            executor.spin_once(timeout_sec=_WAIT_S)

    try:
        if not cameras:
            missing = f"no camera of {', '.join(CAMERAS)} under {prefix}"
            wait_until(lambda: observer.running, missing)
            cameras = observer.running
        observer.watch(cameras, imu)
        wanted = set(cameras)
        missing = f"not every camera_info of {', '.join(cameras)} under {prefix}"
        wait_until(lambda: wanted <= observer.infos.keys(), missing)
        mounting = None
        if imu is not None:
            wait_until(lambda: observer.device_id is not None, f"nothing on {prefix}/config")
            mounting = mounting_of(observer.device_id or "")
        if len(cameras) > 1 or mounting is not None:
            frames = {observer.infos[camera].header.frame_id: camera for camera in cameras}
            observer.watch_transforms(frames)
            missing = f"no stamp with transforms of all of {', '.join(sorted(frames))}"
            wait_until(lambda: observer.poses, missing)
        if mounting is not None:
            missing = f"no head poses on /tf around the images of {cameras[0]}"
            wait_until(lambda: observer.is_head_known(cameras[0]), missing)
        if imu is not None:
            wait_until(lambda: len(observer.imu_ns) >= _IMU_MESSAGES, f"no {prefix}/{imu}/imu")
        return observer.rig(cameras, mounting)
    finally:
        executor.shutdown()
        end_node(observer.node)


class _Observer:
    """A node that keeps the needed messages of one receiver.

    Attributes:
        running: the cameras of CAMERAS that run.
        device_id: of the headset; None until the configuration has come.
        infos: the last camera_info by camera.
        imu_ns: the stamps of the IMU.
        poses: the poses by camera at the latest stamp at which all are known; empty before that.
    """

    def __init__(self, prefix: str) -> None:
        self.node = start_node_named("ml2_export")
        self.running: tuple[str, ...] = ()
        self.device_id: str | None = None
        self.infos: dict[str, CameraInfo] = {}
        self.imu_ns: set[int] = set()
        self.poses: dict[str, Pose] = {}
        self._prefix = prefix
        self._tree: Tree
        self._count = 0
        self._instants: OrderedDict[int, dict[str, Pose]] = OrderedDict()
        self._heads: OrderedDict[int, Pose] = OrderedDict()
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(String, f"{prefix}/config", self._take_config, latched)

    def watch(self, cameras: Sequence[str], imu: str | None) -> None:
        for camera in cameras:
            topic = f"{self._prefix}/{camera}/camera_info"
            self.node.create_subscription(CameraInfo, topic, self._info_taker(camera), 5)
        if imu is not None:
            self.node.create_subscription(Imu, f"{self._prefix}/{imu}/imu", self._take_imu, 200)

    def watch_transforms(self, frames: Mapping[str, str]) -> None:
        """Subscribes to the transforms of these optical frames; `frames` maps frame to camera."""
        self._tree, self._count = Tree.of(frames), len(frames)
        static = QoSProfile(depth=STATIC_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(TFMessage, "/tf_static", self._take_static, static)
        self.node.create_subscription(TFMessage, "/tf", self._take_transforms, 100)

    def is_head_known(self, camera: str) -> bool:
        """Returns True once the head's pose in the camera is a mean of enough."""
        return len(self._instants) >= _MEAN_OF and self._head_in(camera) is not None

    def _head_in(self, camera: str) -> Pose | None:
        whole = {at: it for at, it in self._instants.items() if len(it) == self._count}
        return head_in(whole, self._heads, camera)

    def rig(self, cameras: Sequence[str], mounting: Mounting | None) -> Rig:
        """Returns what has come; with a `mounting`, is_head_known() for the first camera."""
        exists = partial(count_publishers, self.node)
        topics = {camera: image_topic(camera, self._prefix, exists) for camera in cameras}
        if mounting is not None:
            head = self._head_in(cameras[0])
            assert head is not None
            mounting = replace(mounting, pose=self.poses[cameras[0]] @ head @ mounting.pose)
        return Rig(
            tuple(
                RigCamera(
                    topics[camera].full_name(self._prefix),
                    calibration_of(self.infos[camera]),
                    # A single camera needs no pose.
                    self.poses.get(camera, np.eye(4)),
                )
                for camera in cameras
            ),
            rate_hz(self.imu_ns),
            mounting,
        )

    def _take_config(self, message: String) -> None:
        try:
            config = json.loads(message.data)
            streams, device_id = config["streams"], str(config.get("device_id", ""))
            self.running = tuple(it for it in CAMERAS if streams.get(it, {}).get("topics"))
            self.device_id = device_id
        except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
            raise ExportError(f"{self._prefix}/config is not a receiver's configuration") from error

    def _info_taker(self, camera: str) -> Callable[[CameraInfo], None]:
        return lambda message: self.infos.update({camera: message})

    def _take_imu(self, message: Imu) -> None:
        self.imu_ns.add(header_stamp_ns(message.header))

    def _take_static(self, message: TFMessage) -> None:
        try:
            self._tree.stand(message)
        except ValueError as error:
            raise ExportError(f"/tf_static: {error}") from error

    def _take_transforms(self, message: TFMessage) -> None:
        try:
            self._heads.update(self._tree.heads(message))
            for camera, stamp_ns, pose in self._tree.poses(message):
                instant = self._instants.setdefault(stamp_ns, {})
                instant[camera] = pose
                if len(instant) == self._count:
                    self.poses = instant
        except ValueError as error:
            raise ExportError(f"/tf: {error}") from error
        for known in (self._instants, self._heads):
            while len(known) > _STAMPS:
                known.popitem(last=False)
