"""How much later a reference trajectory's stamps are than those of the same motion's images."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from .trajectory import Trajectory

# The second looks closer, about what the first has found.
_STEPS_S = (0.05, 0.005)
_LEAST_TURN_RAD = 1e-3

type Floats = NDArray[np.float64]


def time_offset_s(reference: Trajectory, estimate: Trajectory) -> float | None:
    """What has to be added to the estimate's stamps for both to turn alike at the same time.

    Association and alignment hide a constant shift between images and poses; this shows it. How a
    camera turns, in its own axes, is the same in every world and at every scale. The mean squared
    difference is a parabola of small shifts, so three of them tell where it is least.

    Returns:
        None where too little turns to tell, or stamps do not overlap.
    """
    known_s, known = _turned(reference, reference[0][0])
    at_s, found = _turned(estimate, reference[0][0])
    offset_s = 0.0
    for step_s in _STEPS_S:
        shifted_s = at_s + offset_s
        is_inside = (shifted_s - step_s >= known_s[0]) & (shifted_s + step_s <= known_s[-1])
        inside_s, inside = shifted_s[is_inside], found[is_inside]
        if len(inside) < 2 or np.ptp(inside, axis=0).max() < _LEAST_TURN_RAD:
            return None
        before, now, after = (
            _mean_squared_difference(inside, _interpolated(inside_s + shift_s, known_s, known))
            for shift_s in (-step_s, 0.0, step_s)
        )
        curvature = before - 2 * now + after
        if curvature <= 0:
            return None
        offset_s += step_s * (before - after) / (2 * curvature)
    return float(offset_s)


def _turned(trajectory: Trajectory, origin_ns: int) -> tuple[Floats, Floats]:
    """Seconds, and the sum of all turns until then as rotation vectors in the camera's axes."""
    stamps_s = np.array([stamp_ns - origin_ns for stamp_ns, _ in trajectory]) / 1e9
    turns = [
        cv2.Rodrigues(one[:3, :3].T @ other[:3, :3])[0].ravel()
        for (_, one), (_, other) in pairwise(trajectory)
    ]
    return stamps_s, np.cumsum([np.zeros(3), *turns], axis=0)


def _interpolated(at_s: Floats, known_s: Floats, known: Floats) -> Floats:
    return np.stack([np.interp(at_s, known_s, axis) for axis in known.T], axis=1)


def _mean_squared_difference(found: Floats, expected: Floats) -> float:
    """Of the turns from each stamp to the next."""
    difference = np.diff(found, axis=0) - np.diff(expected, axis=0)
    return float(np.mean(np.sum(difference**2, axis=1)))
