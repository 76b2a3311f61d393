"""Images that were compressed elsewhere, as the tools read them: no more than they may cost."""

import struct
from collections.abc import Iterator
from contextlib import suppress
from types import SimpleNamespace

import cv2
import numpy as np

from compressed_images import SCAN, with_scans
from ml2_tools.images.pixels import pixels_of
from ml2_tools.images.size import MOST_PIXELS, MOST_SCANS, compressed_size

_FORMATS = ("16UC1; compressedDepth rvl", "mono8; jpeg compressed mono8")


def seeds() -> Iterator[bytes]:
    # 2 invalid pixels, 1 of 1000 mm
    yield struct.pack("<iffIII", 0, 0, 0, 3, 1, 0x218AF300)
    for quality in (1, 95):
        grey = np.arange(16 * 9, dtype=np.uint8).reshape(9, 16)
        yield cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
    progressive = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()
    yield progressive
    yield with_scans(progressive, 33)


def read(data: bytes) -> None:
    for format in _FORMATS:
        with suppress(ValueError):
            pixels = pixels_of(SimpleNamespace(format=format, data=data))
            assert pixels.shape[1::-1] == compressed_size(format, data)
            assert 0 < pixels.shape[0] * pixels.shape[1] <= MOST_PIXELS
            assert format.startswith("16UC1") or _last_scans(data) <= MOST_SCANS


def _last_scans(data: bytes) -> int:
    """Returns the number of scans after the last thing that says a size, as a decoder sees it."""
    return data[max(data.rfind(bytes((0xFF, it))) for it in range(0xC0, 0xC3)) :].count(SCAN)
