"""Reads the size of compressed images from their heads, without decoding them."""

from __future__ import annotations

import struct
from collections.abc import Buffer

MOST_PIXELS = 4096 * 3072
RVL_FORMAT = "16UC1; compressedDepth rvl"
# image_transport's head: how the integers are encoded, and two parameters of that; then the size.
_CONFIG, _SIZE = struct.Struct("<iff"), struct.Struct("<II")
DEPTH_HEAD_BYTES = _CONFIG.size + _SIZE.size

_JPEG_SIZE = struct.Struct(">xxxHH")  # after the marker: length, precision, height, width
_MOST_SEGMENTS = 1000
_WITHOUT_LENGTH = {0x01, *range(0xD0, 0xD8)}
_END_OF_HEAD = {0xD8, 0xD9, 0xDA}
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}


def compressed_size(format: str, data: Buffer) -> tuple[int, int] | None:
    """Returns width and height of a CompressedImage; None if it is neither JPEG nor RVL.

    Raises:
        ValueError: the head is invalid, or the size is 0 or above MOST_PIXELS.
    """
    if is_depth(format):
        return depth_size(data) if is_rvl(format) else None
    return jpeg_size(data) if "jpeg" in format else None


def is_depth(format: str) -> bool:
    """Returns True for the format of a compressedDepth image of image_transport."""
    return "compressedDepth" in format


def is_rvl(format: str) -> bool:
    """Returns True for the format of a compressedDepth image whose integers are in RVL."""
    return format.split() == RVL_FORMAT.split()


def depth_size(data: Buffer) -> tuple[int, int]:
    """Returns width and height of a compressedDepth image of integers in RVL.

    Raises:
        ValueError: the head is invalid, or the size is 0 or above MOST_PIXELS.
    """
    found = memoryview(data)
    if len(found) < DEPTH_HEAD_BYTES:
        raise ValueError(f"expected a head of {DEPTH_HEAD_BYTES} bytes, found {len(found)}")
    config = _CONFIG.unpack_from(found)
    if config != (0, 0, 0):
        raise ValueError(f"expected (0, 0, 0) at the start of compressedDepth, found {config}")
    width, height = _SIZE.unpack_from(found, _CONFIG.size)
    return _checked(width, height)


def jpeg_size(data: Buffer) -> tuple[int, int]:
    """Returns width and height of a JPEG.

    Raises:
        ValueError: the head is invalid, or the size is 0 or above MOST_PIXELS.
    """
    found = memoryview(data)
    if bytes(found[:2]) != b"\xff\xd8":
        raise ValueError(f"expected a JPEG, found {len(found)} other bytes")
    at = 2
    for _ in range(_MOST_SEGMENTS):
        if len(found) < at + 2 + _JPEG_SIZE.size or found[at] != 0xFF:
            break
        marker = found[at + 1]
        if marker in _END_OF_HEAD:
            break
        if marker in _FRAMES:
            height, width = _JPEG_SIZE.unpack_from(found, at + 2)
            return _checked(width, height)
        if marker == 0xFF:
            at += 1
        elif marker in _WITHOUT_LENGTH:
            at += 2
        else:
            at += 2 + int.from_bytes(found[at + 2 : at + 4], "big")
    raise ValueError(f"expected a JPEG with a size, found none in {len(found)} bytes")


def _checked(width: int, height: int) -> tuple[int, int]:
    if not 0 < width * height <= MOST_PIXELS:
        raise ValueError(f"expected 1 to {MOST_PIXELS} pixels, found {width}x{height}")
    return width, height
