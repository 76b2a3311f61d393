"""Messages of rclpy about cameras and where they are."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

_SECOND_NS = 1_000_000_000


def stamped(frame: str, stamp_ns: int = 0) -> Header:
    sec, nanosec = divmod(stamp_ns, _SECOND_NS)
    return Header(frame_id=frame, stamp=Time(sec=sec, nanosec=nanosec))


def camera_info(
    header: Header, size: tuple[int, int], model: str, d: Sequence[float], matrix: Any
) -> CameraInfo:
    """A camera that is not rectified; `size` is width and height."""
    k = np.asarray(matrix, np.float64).reshape(3, 3)
    info = CameraInfo(header=header, width=size[0], height=size[1], distortion_model=model)
    info.d, info.k, info.r = list(d), k.ravel(), np.eye(3).ravel()
    info.p = np.hstack([k, np.zeros((3, 1))]).ravel()
    return info


def transform_of(
    parent: Header,
    child: str,
    place: Sequence[float] | NDArray[np.float64],
    turn: Sequence[float] = (0, 0, 0, 1),
) -> Any:
    """A transform; `turn` is a quaternion, its real part last."""
    it: Any = TransformStamped(header=parent, child_frame_id=child)
    moved, rotation = it.transform.translation, it.transform.rotation
    moved.x, moved.y, moved.z = map(float, place)
    rotation.x, rotation.y, rotation.z, rotation.w = map(float, turn)
    return it
