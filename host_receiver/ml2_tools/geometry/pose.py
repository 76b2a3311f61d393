"""Converts ROS transforms to matrices."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

type Pose = NDArray[np.float64]


def pose_of(transform: Any) -> Pose:
    """Returns a geometry_msgs/Transform as a 4x4 matrix.

    Raises:
        ValueError: the quaternion has not length 1, or a value is not finite.
    """
    t, r = transform.translation, transform.rotation
    x, y, z, w = r.x, r.y, r.z, r.w
    if not abs(math.hypot(x, y, z, w) - 1) < 1e-3 or not all(map(math.isfinite, (t.x, t.y, t.z))):
        found = f"{[x, y, z, w]} and {[t.x, t.y, t.z]}"
        raise ValueError(f"expected a unit quaternion and finite metres, found {found}")
    return pose_from((t.x, t.y, t.z), (x, y, z, w))


def pose_from(translation: Iterable[float], rotation: Iterable[float]) -> Pose:
    """Returns metres and a unit quaternion (x, y, z, w) as a 4x4 matrix."""
    x, y, z, w = rotation
    pose = np.eye(4)
    pose[:3, :3] = _matrix(x, y, z, w)
    pose[:3, 3] = list(translation)
    return pose


def weighted_mean(poses: NDArray[np.float64], weights: NDArray[np.float64]) -> Pose:
    """Returns the mean of n x 4 x 4 poses, for weights whose sum is 1.

    The rotation is the one nearest to the mean of the matrices (Moakher 2002). Between two poses
    that are 0.1 rad apart it differs from a slerp by up to 0.02 mrad.
    """
    mean: Pose = np.einsum("n,nij->ij", weights, poses)
    left, _, right = np.linalg.svd(mean[:3, :3])
    mean[:3, :3] = left @ right
    return mean


def _matrix(x: float, y: float, z: float, w: float) -> list[list[float]]:
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def quaternion_of(pose: Pose) -> tuple[float, float, float, float]:
    """Returns the rotation of a pose as x, y, z, w with w >= 0 (Bar-Itzhack 2000)."""
    r = pose[:3, :3]
    traceless = np.empty((4, 4))
    traceless[:3, :3] = r + r.T - np.trace(r) * np.eye(3)
    traceless[3, :3] = traceless[:3, 3] = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    traceless[3, 3] = np.trace(r)
    _, vectors = np.linalg.eigh(traceless)
    x, y, z, w = map(float, vectors[:, -1])
    return (x, y, z, w) if w >= 0 else (-x, -y, -z, -w)
