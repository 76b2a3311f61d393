"""Encodes depth as compressedDepth with RVL, a value at a time, as Wilson's paper describes it.

Makes JPEGs with any number of scans, too, as no encoder does.
"""

import itertools
import struct
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

SCAN = b"\xff\xda"
FORMAT = "16UC1; compressedDepth rvl"


def compressed_depth(mm: NDArray[np.uint16]) -> bytes:
    """Returns the data of a CompressedImage; `mm` is height x width, 0 if invalid."""
    height, width = mm.shape
    return struct.pack("<iffII", 0, 0, 0, width, height) + words(values(mm.ravel().tolist()))


def values(levels: Iterable[int]) -> Iterator[int]:
    """Yields the numbers of invalid and valid pixels, and the differences of the valid ones."""
    runs = [(is_valid, [*run]) for is_valid, run in itertools.groupby(levels, bool)]
    if runs and runs[0][0]:
        runs.insert(0, (False, []))
    if runs and not runs[-1][0]:
        runs.append((True, []))
    before = 0
    for is_valid, run in runs:
        yield len(run)
        for level in run if is_valid else []:
            step, before = level - before, level
            yield 2 * step if step >= 0 else -2 * step - 1


def words(values: Iterable[int]) -> bytes:
    """Returns the values in nibbles of three bits, the lowest first, in words of eight nibbles."""
    nibbles: list[int] = []
    for value in values:
        rest = value
        while rest > 7:
            nibbles.append(rest & 7 | 8)
            rest >>= 3
        nibbles.append(rest)
    nibbles += [0] * (-len(nibbles) % 8)
    return b"".join(
        struct.pack("<I", int("".join(f"{it:x}" for it in nibbles[at : at + 8]), 16))
        for at in range(0, len(nibbles), 8)
    )


def with_scans(jpeg: bytes, count: int) -> bytes:
    """Returns the JPEG with its first scan so many times, each with four bytes of its data."""
    begin = jpeg.index(SCAN)
    head_bytes = 2 + int.from_bytes(jpeg[begin + 2 : begin + 4], "big")
    scan = jpeg[begin : begin + head_bytes + 4]
    return jpeg[:begin] + scan * count + b"\xff\xd9"
