"""Decodes the words of RVL: Wilson, "Fast Lossless Depth Image Compression", ISS 2017.

An image is a list of values: a number of invalid pixels, a number of valid ones, the difference of
each of these to the valid pixel before it, and again. A value is one or more nibbles, the lowest
three bits first; the top bit of a nibble is set if another one follows. Nibbles fill little-endian
words of 32 bits from the top; zeros fill the last word.
"""

from collections.abc import Buffer

import numpy as np
from numpy.typing import NDArray

_WORD_BYTES = 4
_WORD_NIBBLES = 2 * _WORD_BYTES
_MOST_NIBBLES = 8  # of a value below 2^24
_MOST_LEVEL = 65535

type _Values = NDArray[np.int32]


def decode_rvl(data: Buffer, count: int) -> NDArray[np.uint16]:
    """Returns `count` pixels, at most 2^24 - 1; 0 is invalid.

    The memory that it needs is proportional to the data's length, until they prove to be valid.

    Raises:
        ValueError: the data are invalid, or have another number of pixels.
    """
    # A pixel has at most six nibbles, which then include the numbers of pixels.
    most = 3 * count + 3 * _WORD_BYTES
    found = np.frombuffer(data, np.uint8)
    if not 0 < len(found) <= most or len(found) % _WORD_BYTES:
        raise ValueError(f"expected RVL words, at most {most} bytes, found {len(found)} bytes")
    values = _values(found)
    heads, end = _heads(values, count)
    if end > len(values):
        raise ValueError(f"expected {count} pixels in RVL, found an end in the last of them")
    runs = np.stack([values[heads], values[heads + 1]], axis=1).ravel()
    if (total := int(runs.sum(dtype=np.int64))) != count:
        raise ValueError(f"expected {count} pixels in RVL, found {total}")
    is_step = np.ones(len(values), np.bool_)
    is_step[heads] = is_step[heads + 1] = False
    is_step[end:] = False
    pixels = np.zeros(count, np.uint16)
    pixels[np.repeat(np.arange(len(runs)) % 2 == 1, runs)] = _levels(values[is_step])
    return pixels


def _values(data: NDArray[np.uint8]) -> _Values:
    """Decodes all values at once; a loop over the nibbles would take 30 times as long."""
    bytes = data.reshape(-1, _WORD_BYTES)[:, ::-1].ravel()
    nibbles = np.empty(2 * len(bytes), np.uint8)
    nibbles[0::2] = bytes >> 4
    nibbles[1::2] = bytes & 15
    ends = np.flatnonzero(nibbles < 8)
    if not len(ends) or ends[-1] != len(nibbles) - 1:
        raise ValueError("expected the end of a value at the end of RVL, found its start")
    lengths = np.diff(ends, prepend=-1)
    longest = int(lengths.max())
    if longest > _MOST_NIBBLES:
        raise ValueError(f"expected at most {_MOST_NIBBLES} nibbles in a value, found {longest}")
    values = nibbles[ends].astype(np.int32)
    for length in range(1, longest):
        longer = np.flatnonzero(lengths > length)
        values[longer] = values[longer] << 3 | nibbles[ends[longer] - length] & 7
    return values


def _heads(values: _Values, count: int) -> tuple[NDArray[np.intp], int]:
    """Returns the index of each number of invalid pixels, and the index after the last run."""
    # Only the first run, the last one and the zeros of the last word may be empty.
    most = count // 2 + 2 + _WORD_NIBBLES
    nexts = (values[1:] + 2).data  # faster than an array or a list
    heads, head, last = list[int](), 0, len(nexts)
    while head < last:
        heads.append(head)
        if len(heads) > most:
            raise ValueError(f"expected at most {most} runs of {count} pixels in RVL, found more")
        head += nexts[head]
    return np.array(heads, np.intp), head


def _levels(steps: _Values) -> NDArray[np.int64]:
    """Returns the valid pixels from their differences; positive and negative ones take turns."""
    levels = np.cumsum((steps >> 1) ^ -(steps & 1), dtype=np.int64)
    if levels.size and not 0 < levels.min() <= levels.max() <= _MOST_LEVEL:
        found = f"{levels.min()} to {levels.max()}"
        raise ValueError(f"expected valid pixels of 1 to {_MOST_LEVEL} in RVL, found {found}")
    return levels
