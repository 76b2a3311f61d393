"""The types of a camera's images and of its trajectory."""

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from ..geometry.pose import Pose

# stamp_ns and height x width grey levels, with the lens's distortion; stamps rise.
type Images = Iterable[tuple[int, NDArray[np.uint8]]]
# stamp_ns and the 4x4 pose of the optical frame (x right, y down, z forward); stamps rise.
type Trajectory = list[tuple[int, Pose]]
# Is told a step, how much of it is done, and how much there is; 0 if that is not known.
type Progress = Callable[[str, int, int], None]


def untold(step: str, done: int, total: int) -> None:
    """A Progress that tells nobody."""
