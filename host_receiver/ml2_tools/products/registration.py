"""Depth as another camera would measure it, pixel by pixel of its image."""

from __future__ import annotations

import functools
import math

import cv2
import numpy as np

from ..geometry.lens import Floats, Lens
from ..geometry.pose import Pose
from .points import flat_index, points_of, seen_by


def register(z: Floats, lens: Lens, source_to_target: Pose, target: Lens) -> Floats:
    """z along the optical axis of `target`, in its image and distortion; NaN where unknown.

    Each measurement covers the pixels it is as large as there, and the nearest of them counts.

    Raises:
        ValueError: `z` has not the size of its lens.
    """
    u, v, moved_z = seen_by(points_of(z, lens), source_to_target, target)
    index, is_inside = flat_index(u, v, target)
    nearest = np.full(target.width * target.height, np.inf, np.float32)
    np.minimum.at(nearest, index[is_inside], moved_z[is_inside])
    image = nearest.reshape(target.height, target.width)
    footprint = _footprint_px(lens, target)
    if footprint > 1:
        # The least of a neighbourhood, which OpenCV calls erosion.
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
    """The odd number of the target's pixels that one of `lens` is as wide as, rounded up."""
    ratio = max(target.fx / lens.fx, target.fy / lens.fy)
    return 2 * math.ceil((ratio - 1) / 2 - 1e-3) + 1 if ratio > 1 else 1
