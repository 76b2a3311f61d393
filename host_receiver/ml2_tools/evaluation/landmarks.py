"""Points in the world, each the one nearest to all rays from which it was seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.pose import Pose

type Floats = NDArray[np.float64]

_GROWTH = 4096
# Rays that differ by this much tell the depth to a few per cent when pixels are a tenth off.
_LEAST_ANGLE_RAD = np.radians(1.5)


class Landmarks:
    """By the numbers of their tracks, which must be small integers.

    Of every point the sum A of the projections across its rays and b of those applied to the
    rays' origins is kept, so A x = b is the least-squares intersection of all rays so far, and the
    smallest eigenvalue of A tells how far apart the rays are.
    """

    def __init__(self) -> None:
        self._a: Floats = np.zeros((0, 3, 3))
        self._b: Floats = np.zeros((0, 3))
        self._points: Floats = np.zeros((0, 3))
        self._is_known = np.zeros(0, bool)

    def see(self, ids: NDArray[np.int64], rays: Floats, pose: Pose) -> None:
        """Adds one ray each, n x 3 along the camera's axes, from where the camera is."""
        self._grow(int(ids.max(initial=-1)) + 1)
        directions = rays @ pose[:3, :3].T
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
        origin = pose[:3, 3]
        # Near rays tell more: the same error in pixels is a smaller one in metres.
        distances = np.linalg.norm(self._points[ids] - origin, axis=1)
        weights = np.where(self._is_known[ids], 1 / np.maximum(distances, 0.1) ** 2, 1.0)
        self._a[ids] += weights[:, None, None] * across
        self._b[ids] += weights[:, None] * (across @ origin)
        self._solve(ids)

    def known(self, ids: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Of which the place is known."""
        self._grow(int(ids.max(initial=-1)) + 1)
        return self._is_known[ids]

    def points(self, ids: NDArray[np.int64]) -> Floats:
        """n x 3, in the world."""
        return self._points[ids]

    def _solve(self, ids: NDArray[np.int64]) -> None:
        values = np.linalg.eigvalsh(self._a[ids])
        is_apart = values[:, 0] > values[:, 2] / 2 * (1 - np.cos(_LEAST_ANGLE_RAD))
        apart = ids[is_apart]
        self._points[apart] = np.linalg.solve(self._a[apart], self._b[apart, :, None])[..., 0]
        self._is_known[apart] = True

    def _grow(self, count: int) -> None:
        missing = count - len(self._is_known)
        if missing > 0:
            more = missing + _GROWTH
            self._a = np.concatenate([self._a, np.zeros((more, 3, 3))])
            self._b = np.concatenate([self._b, np.zeros((more, 3))])
            self._points = np.concatenate([self._points, np.zeros((more, 3))])
            self._is_known = np.concatenate([self._is_known, np.zeros(more, bool)])
