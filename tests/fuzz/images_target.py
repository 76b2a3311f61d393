"""Images that were compressed elsewhere, as the tools read them."""

import struct
from collections.abc import Iterator
from contextlib import suppress
from types import SimpleNamespace

import cv2
import numpy as np

from ml2_tools.images.pixels import pixels_of
from ml2_tools.images.size import compressed_size

_FORMATS = ("16UC1; compressedDepth rvl", "mono8; jpeg compressed mono8")


def seeds() -> Iterator[bytes]:
    # 2 invalid pixels, 1 of 1000 mm
    yield struct.pack("<iffIII", 0, 0, 0, 3, 1, 0x218AF300)
    for quality in (1, 95):
        grey = np.arange(16 * 9, dtype=np.uint8).reshape(9, 16)
        yield cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


def read(data: bytes) -> None:
    for format in _FORMATS:
        with suppress(ValueError):
            pixels = pixels_of(SimpleNamespace(format=format, data=data))
            assert pixels.shape[1::-1] == compressed_size(format, data)
