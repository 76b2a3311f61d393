"""One picture of all image streams, as they arrived."""

import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message

from ml2_receiver.topics.message_types import message_class
from ml2_tools.images.pixels import pixels_of

_TILE = (400, 300)
_LABEL_INDENT, _LABEL_SCALE = 6, 0.45
_LABEL_HEIGHT = 28
_IMAGE_TYPES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")


def write_contact_sheet(last: dict[str, tuple[str, bytes]], path: Path) -> None:
    """Writes a PNG with one labelled tile for each image topic; nothing when there is none.

    Args:
        last: topic -> (ROS type, CDR payload).
        path: the PNG to write.
    """
    tiles = [
        _tile(topic, decoded_image(message_type, payload))
        for topic, (message_type, payload) in sorted(last.items())
        if message_type in _IMAGE_TYPES
    ]
    if not tiles:
        return
    columns = math.ceil(math.sqrt(len(tiles)))
    tiles += [np.zeros_like(tiles[0])] * (-len(tiles) % columns)
    rows = [np.hstack(tiles[i : i + columns]) for i in range(0, len(tiles), columns)]
    cv2.imwrite(str(path), np.vstack(rows))


def decoded_image(message_type: str, payload: bytes) -> NDArray[Any]:
    message = deserialize_message(payload, message_class(message_type))
    if getattr(message, "encoding", "") == "32SC1":
        rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
        return _coloured(rows.view(np.int32)[:, : message.width])
    pixels = pixels_of(message)
    if pixels.ndim == 3:
        return pixels
    return (
        cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR) if pixels.dtype == np.uint8 else _coloured(pixels)
    )


def _coloured(values: NDArray[Any]) -> NDArray[Any]:
    """Depth and its kind from near (red) to far (blue); black where there is no value."""
    known = np.isfinite(values)
    values = np.where(known, values, 0).astype(np.float32)
    # Row 0 of a simulated frame carries its number, not the scene.
    low, high = np.percentile(values[1:][known[1:]], (2, 98)) if known[1:].any() else (0.0, 1.0)
    scaled = np.clip((values - low) / max(high - low, 1e-9), 0, 1)
    coloured = cv2.applyColorMap((255 * (1 - scaled)).astype(np.uint8), cv2.COLORMAP_JET)
    coloured[~known] = 0
    return coloured


def _tile(label: str, picture: NDArray[Any]) -> NDArray[Any]:
    width, height = _TILE
    scale = min(width / picture.shape[1], height / picture.shape[0])
    size = (round(picture.shape[1] * scale), round(picture.shape[0] * scale))
    tile = np.zeros((height + _LABEL_HEIGHT, width, 3), np.uint8)
    x, y = (width - size[0]) // 2, (height - size[1]) // 2
    tile[y : y + size[1], x : x + size[0]] = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    font = cv2.FONT_HERSHEY_SIMPLEX
    (label_width, _), _ = cv2.getTextSize(label, font, _LABEL_SCALE, 1)
    scale = _LABEL_SCALE * min(1, (width - 2 * _LABEL_INDENT) / label_width)
    cv2.putText(tile, label, (_LABEL_INDENT, height + 19), font, scale, (255, 255, 255), 1)
    return tile
