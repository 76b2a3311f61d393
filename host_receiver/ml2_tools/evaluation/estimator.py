"""What makes a trajectory of images."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.pose import Pose

type Images = Iterable[tuple[int, NDArray[np.uint8]]]
type Trajectory = list[tuple[int, Pose]]


class Estimator(Protocol):
    """Where a camera was, from nothing but its images."""

    def __call__(self, images: Images, camera: Camera) -> Trajectory:
        """Estimates the pose of each image.

        Args:
            images: stamp_ns and height x width grey levels, distorted as the lens made them; stamps
                rise. Read once, in order; an image is the estimator's to keep.
            camera: the lens, and with it the pinhole camera that `rectify` makes of it.

        Returns:
            stamp_ns and the 4x4 pose of the optical frame (x right, y down, z forward) in a world
            of the estimator's choice and scale, by rising stamp; images it could not place are
            missing.

        Raises:
            EvaluationError: these images give no trajectory.
        """
