"""How much later a reference trajectory's stamps are than those of the same motion's images."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .estimator import Trajectory

_STEP_S = 0.05

type Floats = NDArray[np.float64]


def time_offset_s(reference: Trajectory, estimate: Trajectory) -> float | None:
    """What has to be added to the estimate's stamps for the best agreement of positions.

    Association and alignment hide a constant shift between images and poses; this shows it. The
    mean squared error is a parabola of small shifts, so three of them tell where it is least.

    Returns:
        None where too little moves to tell, or stamps do not overlap.
    """
    known_s, known = _positions(reference, reference[0][0])
    at_s, found = _positions(estimate, reference[0][0])
    is_inside = (at_s - _STEP_S >= known_s[0]) & (at_s + _STEP_S <= known_s[-1])
    at_s, found = at_s[is_inside], found[is_inside]
    if len(at_s) < 4:
        return None
    try:
        before, now, after = (
            _mean_squared_error(found, _interpolated(at_s + shift_s, known_s, known))
            for shift_s in (-_STEP_S, 0.0, _STEP_S)
        )
    except cv2.error:  # all on one line
        return None
    curvature = before - 2 * now + after
    return float(_STEP_S * (before - after) / (2 * curvature)) if curvature > 0 else None


def _positions(trajectory: Trajectory, origin_ns: int) -> tuple[Floats, Floats]:
    stamps_s = np.array([stamp_ns - origin_ns for stamp_ns, _ in trajectory]) / 1e9
    return stamps_s, np.array([pose[:3, 3] for _, pose in trajectory])


def _interpolated(at_s: Floats, known_s: Floats, known: Floats) -> Floats:
    return np.stack([np.interp(at_s, known_s, axis) for axis in known.T], axis=1)


def _mean_squared_error(found: Floats, expected: Floats) -> float:
    """After the Sim(3) alignment."""
    alignment, scale = cv2.estimateAffine3D(found, expected, force_rotation=True)
    aligned = found @ (scale * alignment[:, :3]).T + alignment[:, 3]
    return float(np.mean(np.sum((aligned - expected) ** 2, axis=1)))
