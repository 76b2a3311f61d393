"""Finds the corners of ArUco markers in images."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

type Image = NDArray[np.uint8]
type Pixels = NDArray[np.float64]

_DETECTOR = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
_CELLS = 6
# The least width of a cell: in smaller cells, the window of cornerSubPix contains other corners.
_LEAST_CELL_PX = 5.0
_STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
_RING = np.exp(1j * np.linspace(0, 2 * np.pi, 32, endpoint=False))
# The radii of two rings, inside and around the window of cornerSubPix.
_RING_CELLS = (0.5, 0.9)
_LEAST_CONTRAST = 40


def corners(grey: Image) -> list[tuple[int, int, Pixels]]:
    """Returns tag, corner (0 to 3, clockwise from the top left) and pixel of visible corners."""
    quads, ids, _ = _DETECTOR.detectMarkers(grey)
    found = []
    for quad, tag in zip(quads, ids.ravel() if ids is not None else [], strict=True):
        sides = np.linalg.norm(np.roll(quad[0], 1, axis=0) - quad[0], axis=1)
        cell_px = sides.min() / _CELLS
        if cell_px < _LEAST_CELL_PX:
            continue
        half = int(cell_px * 0.6)
        refined = cv2.cornerSubPix(grey, quad[0].copy(), (half, half), (-1, -1), _STOP)
        for number, pixel in enumerate(refined.reshape(4, 2).astype(np.float64)):
            if all(_is_saddle(grey, pixel, radius * cell_px) for radius in _RING_CELLS):
                found.append((int(tag), number, pixel))
    return found


def _is_saddle(grey: Image, pixel: Pixels, radius_px: float) -> bool:
    """Returns True if two black squares meet at the pixel, not occluded and inside the image."""
    x = (pixel[0] + radius_px * _RING.real).astype(np.float32)
    y = (pixel[1] + radius_px * _RING.imag).astype(np.float32)
    if min(x.min(), y.min()) < 1 or x.max() > grey.shape[1] - 2 or y.max() > grey.shape[0] - 2:
        return False
    ring = cv2.remap(grey, x, y, cv2.INTER_LINEAR).ravel().astype(float)
    is_white = ring > (ring.min() + ring.max()) / 2
    changes = int(np.count_nonzero(is_white != np.roll(is_white, 1)))
    differs_across = int(np.count_nonzero(is_white != np.roll(is_white, len(ring) // 2)))
    has_contrast = bool(np.ptp(ring) > _LEAST_CONTRAST)
    return has_contrast and changes == 4 and differs_across <= 4
