"""Makes JPEGs of image messages."""

from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..images.pixels import is_compressed, pixels_of
from ..images.size import jpeg_size

_LONGEST_SIDE = 640
_QUALITY = 80
_FULL_QUALITY = 95
# A JPEG of a camera goes to the browser as it is, unless it has more bytes than this.
_MOST_PASSED_BYTES = 256 * 1024
# The ends of scales, times powers of ten: they change seldom while the scene changes.
_STEPS = (1, 2, 5)
_LEAST_FAR_M, _MOST_FAR_M = 0.5, 1000.0
# Enough pixels to tell a percentile.
_SCALE_STEP = 4
# Turbo, with black for invalid distances.
_COLOURS = cv2.applyColorMap(np.arange(256, dtype=np.uint8), cv2.COLORMAP_TURBO)
_COLOURS[0] = 0


class Preview(NamedTuple):
    """A JPEG. `far_m` is the distance at the end of the colour scale; 0 without a scale."""

    jpeg: bytes
    far_m: float


def preview_of(message: Any, is_distance: bool) -> Preview:
    """Returns a JPEG of an Image or CompressedImage whose longer side is at most 640 pixels.

    A JPEG of up to 256 KiB is passed unchanged, in any size. Distances become colours of the Turbo
    map from 0 to `far_m`; invalid ones become black. Other float pixels become grey, and the
    brightest hundredth of them white.

    Args:
        is_distance: True if float pixels are distances in metres.

    Raises:
        ValueError: the image is invalid, or has an encoding that pixels_of() does not read.
    """
    if _is_jpeg(message) and len(message.data) <= _MOST_PASSED_BYTES:
        return _passed(message)
    return _encoded(_reduced(pixels_of(message)), is_distance, _QUALITY)


def full_of(message: Any, is_distance: bool) -> Preview:
    """Returns a JPEG of an image in full size, in the colours of preview_of().

    A JPEG is passed unchanged.

    Raises:
        ValueError: as preview_of().
    """
    if _is_jpeg(message):
        return _passed(message)
    return _encoded(pixels_of(message), is_distance, _FULL_QUALITY)


def _is_jpeg(message: Any) -> bool:
    return is_compressed(message) and "jpeg" in message.format


def _passed(message: Any) -> Preview:
    jpeg_size(message.data)
    return Preview(bytes(message.data), 0)


def _encoded(pixels: NDArray[Any], is_distance: bool, quality: int) -> Preview:
    if pixels.dtype == np.uint8:
        return Preview(_jpeg(pixels, quality), 0)
    if not is_distance:
        return Preview(_jpeg(_grey(pixels), quality), 0)
    levels, far_m = _coloured(pixels)
    return Preview(_jpeg(levels, quality), far_m)


def _reduced(pixels: NDArray[Any]) -> NDArray[Any]:
    height, width = pixels.shape[:2]
    share = _LONGEST_SIDE / max(height, width)
    if share >= 1:
        return pixels
    size = max(1, round(width * share)), max(1, round(height * share))
    # The mean with an invalid distance would be invalid, and that with another surface wrong.
    is_grey = pixels.dtype == np.uint8
    return cv2.resize(pixels, size, interpolation=cv2.INTER_AREA if is_grey else cv2.INTER_NEAREST)


def _coloured(metres: NDArray[np.float32]) -> tuple[NDArray[Any], float]:
    """Returns the colours, and the distance at the end of their scale."""
    is_valid = np.isfinite(metres) & (metres > 0)
    known = np.where(is_valid, metres, np.float32(0))
    some = known[::_SCALE_STEP, ::_SCALE_STEP]
    far_m = _scale_end(some[some > 0])
    levels = np.maximum(cv2.convertScaleAbs(known, alpha=255 / far_m), is_valid)
    return cv2.applyColorMap(levels, _COLOURS), far_m


def _scale_end(metres: NDArray[np.float32]) -> float:
    """Returns the first step at or above 99 of 100 distances."""
    far_m = float(np.percentile(metres, 99)) if metres.size else 0
    far_m = min(max(far_m, _LEAST_FAR_M), _MOST_FAR_M)
    power = 10.0 ** np.floor(np.log10(far_m))
    return float(next((it * power for it in _STEPS if far_m <= it * power), 10 * power))


def _grey(values: NDArray[np.float32]) -> NDArray[np.uint8]:
    # Differences of the largest float32 have no room in float32.
    known = np.nan_to_num(values, nan=0, posinf=0, neginf=0).astype(np.float64)
    white = float(np.percentile(known, 99)) or 1.0
    return np.asarray(np.clip(known / white, 0, 1) * 255, np.uint8)


def _jpeg(pixels: NDArray[Any], quality: int) -> bytes:
    done, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise ValueError(f"OpenCV makes no JPEG of {pixels.shape[1]}x{pixels.shape[0]} pixels")
    return data.tobytes()
