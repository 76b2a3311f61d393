"""Reads the size of compressed images, and what they would cost, without decoding them."""

import struct
from collections.abc import Buffer

MOST_PIXELS = 4096 * 3072
# Longer sides are none that OpenCV encodes.
MOST_SIDE = 65500
# Each scan is a pass over all pixels, even if it has no more than ten bytes. Encoders write about
# ten for a progressive JPEG.
MOST_SCANS = 32
RVL_FORMAT = "16UC1; compressedDepth rvl"
# image_transport's head: how the integers are encoded, and two parameters of that; then the size.
_CONFIG, _SIZE = struct.Struct("<iff"), struct.Struct("<II")
DEPTH_HEAD_BYTES = _CONFIG.size + _SIZE.size

_JPEG_SIZE = struct.Struct(">xxxHH")  # after the marker: length, precision, height, width
_MOST_SEGMENTS = 1000
_SCAN = 0xDA
_WITHOUT_LENGTH = {0x01, *range(0xD0, 0xD8)}
_END_OF_HEAD = {0xD8, 0xD9, _SCAN}
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
    return checked_size(width, height)


def jpeg_size(data: Buffer) -> tuple[int, int]:
    """Returns width and height of a JPEG whose decoding takes a bounded time.

    Raises:
        ValueError: the head is invalid, the size is 0 or above MOST_PIXELS, or there are more than
            MOST_SCANS scans.
    """
    found = memoryview(data).cast("B")
    if bytes(found[:2]) != b"\xff\xd8":
        raise ValueError(f"expected a JPEG, found {len(found)} other bytes")
    size, scans_at = _read_head(found)
    # A decoder that has lost its place may take bytes for a scan that are none: all are counted.
    if (scans := bytes(found[scans_at:]).count(bytes((0xFF, _SCAN)))) > MOST_SCANS:
        raise ValueError(f"expected at most {MOST_SCANS} scans in a JPEG, found {scans}")
    return size


def _read_head(data: memoryview) -> tuple[tuple[int, int], int]:
    """Returns width and height of a JPEG, and where its first scan begins.

    Where a decoder would pass over other bytes, this refuses: both find the same segments.
    """
    at, size = 2, None
    for _ in range(_MOST_SEGMENTS):
        if len(data) < at + 2 + _JPEG_SIZE.size or data[at] != 0xFF:
            break
        marker = data[at + 1]
        if marker in _END_OF_HEAD:
            if marker != _SCAN or size is None:
                break
            return size, at
        if marker in _FRAMES and size is None:
            height, width = _JPEG_SIZE.unpack_from(data, at + 2)
            size = checked_size(width, height)
        if marker == 0xFF:
            at += 1
        elif marker in _WITHOUT_LENGTH:
            at += 2
        else:
            length = int.from_bytes(data[at + 2 : at + 4], "big")
            if marker == 0 or length < 2:
                break
            at += 2 + length
    raise ValueError(f"expected a JPEG with a size and a scan, found none in {len(data)} bytes")


def checked_size(width: int, height: int) -> tuple[int, int]:
    """Returns the size of an image that can be read in a bounded time, and is not empty.

    Raises:
        ValueError: it has no pixel, more than MOST_PIXELS, or a side above MOST_SIDE.
    """
    if not 0 < width * height <= MOST_PIXELS:
        raise ValueError(f"expected 1 to {MOST_PIXELS} pixels, found {width}x{height}")
    if max(width, height) > MOST_SIDE:
        raise ValueError(
            f"expected at most {MOST_SIDE} pixels side by side, found {width}x{height}"
        )
    return width, height
