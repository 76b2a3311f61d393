"""Finds ArUco markers in images, by nothing but the image."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_DETECTOR = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
_CELLS = 6
# Cells across: in smaller ones the window of cornerSubPix would see other corners.
_LEAST_CELL_PX = 5.0
_STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)


def markers(grey: NDArray[np.uint8]) -> dict[int, NDArray[np.float64]]:
    """The four corners in pixels of every marker that is seen large enough, by its id."""
    corners, ids, _ = _DETECTOR.detectMarkers(grey)
    found = {}
    for quad, tag in zip(corners, ids.ravel() if ids is not None else [], strict=True):
        sides = np.linalg.norm(np.roll(quad[0], 1, axis=0) - quad[0], axis=1)
        cell = sides.min() / _CELLS
        if cell < _LEAST_CELL_PX:
            continue
        half = int(cell * 0.6)
        refined = cv2.cornerSubPix(grey, quad[0].copy(), (half, half), (-1, -1), _STOP)
        found[int(tag)] = refined.reshape(4, 2).astype(np.float64)
    return found
