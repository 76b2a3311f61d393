"""Reads the pixels of image messages, whatever library decoded the messages."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray


def pixels_of(message: Any) -> NDArray[Any]:
    """Returns the pixels of an Image in mono8 or 32FC1, height x width, without a copy.

    Raises:
        ValueError: the encoding is another, or the data have the wrong length.
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
    """Decodes CompressedImages; repeated calls with the same message decode it only once."""

    def __init__(self) -> None:
        self._last: tuple[Any, NDArray[np.uint8]] | None = None

    def __call__(self, message: Any) -> NDArray[np.uint8]:
        """Returns the pixels, height x width x 3, in the order blue, green, red.

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
