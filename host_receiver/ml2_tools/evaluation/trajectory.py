"""The types of a camera's images and of its trajectory."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ..geometry.pose import Pose

# stamp_ns and height x width grey levels, with the lens's distortion; stamps rise.
type Images = Iterable[tuple[int, NDArray[np.uint8]]]
# stamp_ns and the 4x4 pose of the optical frame (x right, y down, z forward); stamps rise.
type Trajectory = list[tuple[int, Pose]]
