"""Reads the pixels of image messages, whatever library decoded the messages."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ml2_receiver.printable import printable

from .rvl import decode_rvl
from .size import (
    DEPTH_HEAD_BYTES,
    RVL_FORMAT,
    checked_size,
    depth_size,
    is_depth,
    is_rvl,
    jpeg_size,
)

_MM_PER_M = 1000
_MOST_WORD = 100


def pixels_of(message: Any) -> NDArray[Any]:
    """Returns the pixels of an Image or a CompressedImage; those of video are not decoded.

    | message | pixels |
    |---|---|
    | Image in mono8 | uint8, height x width, without a copy |
    | Image in 32FC1 | float32, height x width, without a copy |
    | JPEG with the format mono8 | uint8, height x width |
    | other JPEG | uint8, height x width x 3, in the order blue, green, red |
    | compressedDepth in RVL | float32, height x width, in metres, NaN where the depth is invalid |

    Raises:
        ValueError: the encoding is another, the data are invalid, the image is empty, has more than
            4096 x 3072 pixels or more scans than decoders read at once, or is one of a video.
    """
    if hasattr(message, "pts") or getattr(message, "format", "") == "h264":
        raise ValueError("expected an image, found video: use another format, or image_transport")
    if not is_compressed(message):
        return _plain(message)
    if is_depth(message.format):
        return _depth(message)
    return _jpeg(message)


def is_compressed(message: Any) -> bool:
    """Returns True for a CompressedImage, False for an Image."""
    return hasattr(message, "format")


def encoding_of(pixels: NDArray[Any]) -> str:
    """Returns the encoding of an Image that has the result of pixels_of()."""
    if pixels.ndim == 3:
        return "bgr8"
    return "mono8" if pixels.dtype == np.uint8 else "32FC1"


def grey_of(message: Any) -> NDArray[Any]:
    """Returns the pixels of an image as height x width; those of a colour image become grey.

    Raises:
        ValueError: as pixels_of().
    """
    pixels = pixels_of(message)
    return cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY) if pixels.ndim == 3 else pixels


def _quoted(word: str) -> str:
    return f"'{printable(word, _MOST_WORD)}'"


def _plain(message: Any) -> NDArray[Any]:
    types: dict[str, Any] = {"mono8": np.uint8, "32FC1": np.float32}
    if message.encoding not in types or message.is_bigendian:
        raise ValueError(
            f"expected mono8 or 32FC1, little endian, found {_quoted(message.encoding)}"
        )
    type = np.dtype(types[message.encoding])
    row_bytes = message.width * type.itemsize
    found = len(message.data)
    if message.step < row_bytes or found != message.step * message.height:
        size = f"{message.width}x{message.height}, step {message.step}"
        raise ValueError(f"expected the bytes of {size}, found {found}")
    checked_size(message.width, message.height)
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    return rows[:, :row_bytes].view(type)


def _depth(message: Any) -> NDArray[np.float32]:
    if not is_rvl(message.format):
        raise ValueError(f"expected {RVL_FORMAT!r}, found {_quoted(message.format)}")
    width, height = depth_size(message.data)
    levels = decode_rvl(memoryview(message.data)[DEPTH_HEAD_BYTES:], width * height)
    metres = np.divide(levels, _MM_PER_M, dtype=np.float32)
    metres[levels == 0] = np.nan
    return metres.reshape(height, width)


def _jpeg(message: Any) -> NDArray[np.uint8]:
    # OpenCV would decode other formats, too, and any size.
    jpeg_size(message.data)
    is_grey = message.format.startswith("mono8")
    # camera_info describes the pixels as they are stored, not turned as EXIF says.
    mode = cv2.IMREAD_GRAYSCALE if is_grey else cv2.IMREAD_COLOR
    data = np.frombuffer(message.data, np.uint8)
    try:
        image = cv2.imdecode(data, mode | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error as error:
        raise ValueError(f"expected a JPEG: {error}") from error
    if image is None:
        raise ValueError(f"expected a JPEG, found {len(data)} other bytes")
    return image.astype(np.uint8, copy=False)
