"""The encoders of libml2sensors.so: any content, size, stride and quality decodes, within bounds.

Nothing tells libFuzzer what an input reaches in C, so its bytes only seed what is drawn here.
"""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compressed_images import FORMAT, compressed_depth
from ml2_tools.images.pixels import pixels_of
from native_encoders import DEPTH_RVL, GREY_JPEG, encode

Draw = Callable[[np.random.Generator, tuple[int, int]], NDArray[Any]]

_LARGEST_SIDE = 40
_GREY: list[Draw] = [
    lambda random, shape: random.integers(0, 256, shape, np.uint8),
    lambda random, shape: (random.integers(0, 2, shape) * 255).astype(np.uint8),
    lambda random, shape: np.full(shape, random.integers(0, 256), np.uint8),
    lambda random, shape: random.normal(random.uniform(0, 255), 3, shape).clip(0, 255).astype("u1"),
    lambda random, shape: (random.integers(0, 50, shape) == 0).astype(np.uint8) * 255,
]
_DEPTH: list[Draw] = [
    lambda random, shape: random.integers(0, 2**32, shape, np.uint32).view(np.float32),
    lambda random, shape: random.uniform(-1, 70, shape).astype(np.float32),
    lambda random, shape: random.choice(np.array([0, 0.001, 65.5, np.nan], np.float32), shape),
    lambda random, shape: np.full(shape, random.uniform(0, 66), np.float32),
    lambda random, shape: (
        random.normal(2, 0.01, shape).astype(np.float32) * (random.random(shape) < random.random())
    ),
]


def seeds() -> Iterator[bytes]:
    yield b"seed"


def read(data: bytes) -> None:
    """Encodes and decodes one image that data choose."""
    random = np.random.default_rng(list(data))
    rows, columns, padding = random.integers(1, _LARGEST_SIDE, 3)
    shape = int(rows), int(columns + padding)
    if random.integers(2):
        _read_grey(_drawn(_GREY, random, shape)[:, :columns], int(random.integers(1, 101)))
    else:
        _read_depth(_drawn(_DEPTH, random, shape)[:, :columns])


def _drawn(draws: list[Draw], random: np.random.Generator, shape: tuple[int, int]) -> NDArray[Any]:
    return np.ascontiguousarray(draws[random.integers(len(draws))](random, shape))


def _read_grey(pixels: NDArray[np.uint8], quality: int) -> None:
    jpeg = encode(GREY_JPEG, pixels, quality)
    found = pixels_of(SimpleNamespace(format="mono8; jpeg compressed mono8", data=jpeg))
    assert found.shape == pixels.shape
    if quality == 100:
        assert np.abs(found.astype(int) - pixels).max() <= 3


def _read_depth(metres: NDArray[np.float32]) -> None:
    data = encode(DEPTH_RVL, metres)
    found = np.nan_to_num(pixels_of(SimpleNamespace(format=FORMAT, data=data)) * 1000)
    assert data == compressed_depth(found.round().astype(np.uint16))
    with np.errstate(over="ignore", invalid="ignore"):
        expected = metres.astype(np.float64) * 1000
        is_valid = (expected > 0.501) & (expected < 65535.49)
        is_none = ~((expected > 0.499) & (expected < 65535.51))
    # A float of 65 m has steps of 0.004 mm.
    assert np.abs(found[is_valid] - expected[is_valid]).max(initial=0) <= 0.51
    assert not found[is_none].any()
