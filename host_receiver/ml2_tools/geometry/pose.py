"""Converts ROS transforms to matrices."""

from __future__ import annotations

import math
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
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), t.x],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), t.y],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), t.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
