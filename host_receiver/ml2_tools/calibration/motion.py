"""The motion of a headset: poses of the head, and the data of an inertial unit."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

type Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """Values of three axes, n x 3, with rising stamps in s."""

    stamps_s: Floats
    values: Floats


@dataclass(frozen=True)
class HeadPoses:
    """Poses of head_frame (REP-103: x forward, y left, z up) in a world whose z points up.

    Attributes:
        positions_m: n x 3.
        rotations: n, from the head's axes to the world's.
    """

    stamps_s: Floats
    positions_m: Floats
    rotations: Rotation


@dataclass(frozen=True)
class UnitMotion:
    """The poses of the head, and the data of one unit, on one clock."""

    poses: HeadPoses
    gyroscope: Samples
    accelerometer: Samples
