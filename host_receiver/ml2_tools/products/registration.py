"""Registers depth to the image of another camera."""

import functools
import math

import cv2
import numpy as np

from ..geometry.lens import Floats, Lens
from ..geometry.pose import Pose
from .points import flat_index, points_of, project_points

# The memory and the time grow with it.
_MOST_FOOTPRINT_PX = 64


def register(z: Floats, lens: Lens, source_to_target: Pose, target: Lens) -> Floats:
    """Returns z along the optical axis of `target`, in its distorted image; NaN where unknown.

    Each depth pixel covers as many target pixels as it is wide. Of several depths for one target
    pixel, the nearest one is kept.

    Raises:
        ValueError: `z` does not have the size of its lens, or the lenses differ too much.
    """
    footprint = _footprint_px(lens, target)
    u, v, moved_z = project_points(points_of(z, lens), source_to_target, target)
    index, is_inside = flat_index(u, v, target)
    nearest = np.full(target.width * target.height, np.inf, np.float32)
    np.minimum.at(nearest, index[is_inside], moved_z[is_inside])
    image = nearest.reshape(target.height, target.width)
    if footprint > 1:
        # OpenCV's erosion is the minimum of a neighbourhood.
        image = cv2.erode(
            image,
            np.ones((footprint, footprint), np.uint8),
            borderType=cv2.BORDER_CONSTANT,
            borderValue=np.inf,  # type: ignore[call-overload]
        ).astype(np.float32, copy=False)
    image[np.isinf(image)] = np.nan
    return image


@functools.lru_cache(16)
def _footprint_px(lens: Lens, target: Lens) -> int:
    """Returns the width of one pixel of `lens` in target pixels, rounded up to an odd number."""
    ratio = max(target.fx / lens.fx, target.fy / lens.fy)
    if not ratio <= _MOST_FOOTPRINT_PX:
        found = f"{ratio:.3g}"
        raise ValueError(
            f"expected at most {_MOST_FOOTPRINT_PX} px for a depth pixel, found {found}"
        )
    return 2 * math.ceil((ratio - 1) / 2 - 1e-3) + 1 if ratio > 1 else 1
