"""The numbers of messages that are no images, in the order of their fields."""

import math
from collections.abc import Callable, Mapping
from typing import Any


def _vector(it: Any) -> tuple[float, ...]:
    return it.x, it.y, it.z


def _pose(it: Any) -> tuple[float, ...]:
    q = it.orientation
    return (*_vector(it.position), q.x, q.y, q.z, q.w)


def _detections(it: Any) -> tuple[float, ...]:
    """Returns how many there are, and the pose of the first."""
    first = _pose(it.detections[0].bbox.center) if it.detections else (math.nan,) * 7
    return len(it.detections), *first


def _localization(it: Any) -> tuple[float, ...]:
    """Returns whether the headset has said where it is, and whether it is localized."""
    (status,) = it.status
    values = {pair.key: pair.value for pair in status.values}
    return float(values["localization"] != "unknown"), float(values["localization"] == "localized")


NUMBERS: Mapping[str, Callable[[Any], tuple[float, ...]]] = {
    "sensor_msgs/msg/Imu": lambda it: (
        *_vector(it.angular_velocity),
        *_vector(it.linear_acceleration),
    ),
    "sensor_msgs/msg/MagneticField": lambda it: _vector(it.magnetic_field),
    "sensor_msgs/msg/Joy": lambda it: (*it.axes, *it.buttons),
    "geometry_msgs/msg/PoseStamped": lambda it: _pose(it.pose),
    "geometry_msgs/msg/PoseArray": lambda it: tuple(x for pose in it.poses for x in _pose(pose)),
    "vision_msgs/msg/Detection3DArray": _detections,
    "diagnostic_msgs/msg/DiagnosticArray": _localization,
}
