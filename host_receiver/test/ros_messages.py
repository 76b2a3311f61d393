"""Payloads of ROS messages, encoded by rosbags, which shares nothing with the product."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

type Vector = tuple[float, float, float]

TYPES = get_typestore(Stores.ROS2_JAZZY)
_STILL = (0.0, 0.0, 0.0, 1.0)


def message(type: str, *fields: Any) -> Any:
    return TYPES.types[type](*fields)


def payload(type: str, *fields: Any) -> bytes:
    return bytes(TYPES.serialize_cdr(message(type, *fields), type))


def header(frame: str, sec: int, nanosec: int = 5) -> Any:
    stamp = message("builtin_interfaces/msg/Time", sec, nanosec)
    return message("std_msgs/msg/Header", stamp, frame)


def string(text: str) -> bytes:
    return payload("std_msgs/msg/String", text)


def mono_image(header: Any, pixels: NDArray[np.uint8]) -> bytes:
    height, width = pixels.shape
    fields = (height, width, "mono8", 0, width, pixels.ravel())
    return payload("sensor_msgs/msg/Image", header, *fields)


def compressed_image(header: Any, format: str, data: bytes | NDArray[np.uint8]) -> bytes:
    values = np.frombuffer(data, np.uint8)
    return payload("sensor_msgs/msg/CompressedImage", header, format, values)


def transform(header: Any, child: str, place: Vector) -> bytes:
    """A TFMessage of one transform without a turn."""
    vector = message("geometry_msgs/msg/Vector3", *map(float, place))
    turn = message("geometry_msgs/msg/Quaternion", *_STILL)
    moved = message("geometry_msgs/msg/Transform", vector, turn)
    stamped = message("geometry_msgs/msg/TransformStamped", header, child, moved)
    return payload("tf2_msgs/msg/TFMessage", [stamped])


def imu(header: Any, turn_rate: Vector, acceleration: Vector) -> bytes:
    turn, unknown = message("geometry_msgs/msg/Quaternion", *_STILL), np.zeros(9)
    vectors = (message("geometry_msgs/msg/Vector3", *it) for it in (turn_rate, acceleration))
    fields = [turn, unknown, next(vectors), unknown, next(vectors), unknown]
    return payload("sensor_msgs/msg/Imu", header, *fields)
