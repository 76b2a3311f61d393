"""ROS messages to arrays and back, without a copy where ROS allows it."""

from __future__ import annotations

from array import array
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image, PointCloud2, PointField

from .lens import Floats

_FIELD_BYTES = 4


def pixels_of(message: Any) -> NDArray[Any]:
    """Pixels of an Image in mono8 or 32FC1; they are the message's own.

    Raises:
        ValueError: it is another, or its data are not as long as it says.
    """
    types: dict[str, Any] = {"mono8": np.uint8, "32FC1": np.float32}
    if message.encoding not in types or message.is_bigendian:
        raise ValueError(f"expected mono8 or 32FC1, little endian, found {message.encoding!r}")
    type = np.dtype(types[message.encoding])
    row_bytes = message.width * type.itemsize
    found = len(message.data)
    if message.step < row_bytes or found != message.step * message.height or not found:
        size = f"{message.width}x{message.height}, step {message.step}"
        raise ValueError(f"expected the bytes of {size}, found {found}")
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    return rows[:, :row_bytes].view(type)


class JpegDecoder:
    """Decodes CompressedImages, each once although several products ask."""

    def __init__(self) -> None:
        self._last: tuple[Any, NDArray[np.uint8]] | None = None

    def __call__(self, message: Any) -> NDArray[np.uint8]:
        """height x width x 3, blue first.

        Raises:
            ValueError: OpenCV cannot decode it.
        """
        if self._last is None or self._last[0] is not message:
            data = np.frombuffer(message.data, np.uint8)
            try:
                image = cv2.imdecode(data, cv2.IMREAD_COLOR)
            except cv2.error as error:
                raise ValueError(f"expected a JPEG: {error}") from error
            if image is None:
                raise ValueError(f"expected a JPEG, found {len(data)} other bytes")
            self._last = message, image.astype(np.uint8, copy=False)
        return self._last[1]


def image_message(header: Any, encoding: str, pixels: NDArray[Any]) -> Image:
    """An Image; `pixels` is height x width or height x width x channels."""
    height, width = pixels.shape[:2]
    image = Image(header=header, height=height, width=width, encoding=encoding)
    image.step = pixels.nbytes // height
    image.data = _bytes(pixels)
    return image


def cloud_message(header: Any, points: Floats, rgb: NDArray[np.uint32] | None) -> PointCloud2:
    """An organised cloud of `points`, height x width x 3, with the field rgb if there is any."""
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
    """What rclpy's setters take as it is, where they would look at each byte of a list."""
    data = array("B")
    data.frombytes(np.ascontiguousarray(pixels).data.cast("B"))
    return data
