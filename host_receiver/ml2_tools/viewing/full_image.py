"""The newest image of a stream in full size, and its pixels."""

import math
import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bags.decoding import decoder
from ..images.pixels import pixels_of
from .newest_image import NewestImage
from .preview import Preview, full_of

_PREFIX = "full "


def full_name(stream: str) -> str:
    """Returns the name by which browsers ask for a stream's images in full size."""
    return f"{_PREFIX}{stream}"


class FullImage(NewestImage):
    """The newest image of a stream, in full size and each one. Thread-safe."""

    _most_hz = math.inf

    def __init__(self, stream: str) -> None:
        super().__init__(stream, full_name(stream))
        self._reading = threading.Lock()
        self._pixels: tuple[int, NDArray[Any]] = 0, np.empty((0, 0))

    def pixel(self, column: int, row: int) -> list[float | None]:
        """Returns the value of a pixel of the newest image, as the headset sent it.

        The value is a grey level, red, green and blue, or a float, which is None if it is invalid;
        of depth it is a distance in metres. Outside of the image it is empty.
        """
        with self._reading:
            number, type, payload = self.newest
            if number != self._pixels[0]:
                self._pixels = number, _read(type, payload)
            pixels = self._pixels[1]
        height, width = pixels.shape[:2]
        if not (0 <= row < height and 0 <= column < width):
            return []
        # OpenCV has blue first.
        values = np.atleast_1d(pixels[row, column])[::-1].tolist()
        return [it if math.isfinite(it) else None for it in values]

    def _jpeg_of(self, message: Any, is_distance: bool) -> Preview:
        return full_of(message, is_distance)


def _read(type: str, payload: bytes) -> NDArray[Any]:
    """Returns the pixels of an image; none if it is invalid, as its message for browsers says."""
    try:
        return pixels_of(decoder(type)(payload)) if type else np.empty((0, 0))
    except ValueError:
        return np.empty((0, 0))
