"""Converts arrays to ROS messages, without a copy if ROS allows it."""

from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image, PointCloud2, PointField

from ..geometry.lens import Floats

_FIELD_BYTES = 4


def image_message(header: Any, encoding: str, pixels: NDArray[Any]) -> Image:
    """Returns an Image; `pixels` is height x width or height x width x channels."""
    height, width = pixels.shape[:2]
    image = Image(header=header, height=height, width=width, encoding=encoding)
    image.step = pixels.nbytes // height
    image.data = _bytes(pixels)
    return image


def cloud_message(header: Any, points: Floats, rgb: NDArray[np.uint32] | None) -> PointCloud2:
    """Returns an organised cloud of `points`, height x width x 3, with a field rgb if given."""
    height, width = points.shape[:2]
    names = ["x", "y", "z"] if rgb is None else ["x", "y", "z", "rgb"]
    if rgb is not None:
        points = np.concatenate([points, rgb.view(np.float32)[..., None]], axis=2)
    step = _FIELD_BYTES * len(names)
    cloud = PointCloud2(header=header, height=height, width=width, is_bigendian=False)
    cloud.fields = [
        PointField(name=name, offset=_FIELD_BYTES * index, datatype=PointField.FLOAT32, count=1)
        for index, name in enumerate(names)
    ]
    cloud.point_step, cloud.row_step = step, step * width
    cloud.is_dense = False
    cloud.data = _bytes(points)
    return cloud


def _bytes(pixels: NDArray[Any]) -> array[int]:
    """Returns an array that rclpy's setters take without checking each byte, as in a list."""
    data = array("B")
    data.frombytes(np.ascontiguousarray(pixels).data.cast("B"))
    return data
