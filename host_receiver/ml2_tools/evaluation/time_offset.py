"""Estimates a constant time offset between the stamps of images and of a reference trajectory."""

from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from .trajectory import Trajectory

# The second step refines the result of the first.
_STEPS_S = (0.05, 0.005)
_LEAST_TURN_RAD = 1e-3

type Floats = NDArray[np.float64]


def time_offset_s(reference: Trajectory, estimate: Trajectory) -> float | None:
    """Returns the time to add to the estimate's stamps so that both rotate at the same time.

    The association by stamps and the alignment hide a constant shift between images and poses.
    The rotations in the camera's own axes show it: they are the same in every world and at every
    scale. For small shifts, the mean squared difference of the rotations is a parabola of the
    shift, so three values give its minimum.

    Returns:
        The offset in s; None if the camera rotates too little, or the stamps do not overlap.
    """
    known_s, known = _summed_rotations(reference, reference[0][0])
    at_s, found = _summed_rotations(estimate, reference[0][0])
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


def _summed_rotations(trajectory: Trajectory, origin_ns: int) -> tuple[Floats, Floats]:
    """Returns the stamps in s and, for each, the sum of all rotations from pose to pose so far.

    The rotations are rotation vectors in the camera's axes.
    """
    stamps_s = np.array([stamp_ns - origin_ns for stamp_ns, _ in trajectory]) / 1e9
    turns = [
        cv2.Rodrigues(one[:3, :3].T @ other[:3, :3])[0].ravel()
        for (_, one), (_, other) in pairwise(trajectory)
    ]
    return stamps_s, np.cumsum([np.zeros(3), *turns], axis=0)


def _interpolated(at_s: Floats, known_s: Floats, known: Floats) -> Floats:
    return np.stack([np.interp(at_s, known_s, axis) for axis in known.T], axis=1)


def _mean_squared_difference(found: Floats, expected: Floats) -> float:
    """Returns the mean squared difference of the rotations from each stamp to the next."""
    difference = np.diff(found, axis=0) - np.diff(expected, axis=0)
    return float(np.mean(np.sum(difference**2, axis=1)))
