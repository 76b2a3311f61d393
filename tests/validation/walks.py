"""The walks of the validation: a head walks around the room and looks around.

Each is a closed-form function of time, with the duration and length of one of the thesis's
trajectories.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np

from euroc import Matrix
from ml2_tools.evaluation.tum import quaternion

# The ellipse around the room's centre: its radius across the room, relative to that along it.
_WIDTH = 0.85
_GLANCE_RAD, _GLANCE_S = math.radians(20), 3.5
_NOD_RAD, _TILT_RAD = math.radians(5), math.radians(2)
_STEPS_HZ, _BOB_M, _SWAY_M = 1.8, 0.01, 0.012
_RISE_M = 0.06
# The time until all streams of a headset run, in whole seconds.
REST_S = 2
# The time of acceleration, and of deceleration.
_RAMP_S = 1.0
_RATE_HZ = 100


@dataclass(frozen=True)
class Walk:
    """A walk of the head along an ellipse.

    Attributes:
        camera: the camera that is evaluated.
        path_m: the length of that camera's path.
        turn_deg: the angle around the room's centre; positive to the left.
        radius_m: the radius of the ellipse along the room.
    """

    name: str
    camera: str
    duration_s: float
    path_m: float
    turn_deg: float
    radius_m: float = 1.0

    def head(self, at_s: float) -> Matrix:
        """Returns the pose of the head's body (x forward, y left, z up) in the world.

        The head is at rest before 0 s and after `duration_s`.
        """
        progress = self._progress(at_s)
        glances = 2 * math.pi * round(self.duration_s / _GLANCE_S) * progress
        steps = 2 * math.pi * round(self.duration_s * _STEPS_HZ / 2) * progress
        turn = math.radians(self.turn_deg) * progress
        radius_m = self.radius_m + _SWAY_M * math.sin(steps)
        pose = np.eye(4)
        pose[:3, 3] = (
            radius_m * math.cos(turn),
            _WIDTH * radius_m * math.sin(turn),
            _RISE_M * math.sin(2 * math.pi * progress) + _BOB_M * math.sin(2 * steps),
        )
        facing = turn + math.copysign(math.pi / 2, self.turn_deg)
        pose[:3, :3] = (
            _rotation(2, facing + _GLANCE_RAD * math.sin(glances))
            @ _rotation(1, _NOD_RAD * math.sin(glances / 2))
            @ _rotation(0, _TILT_RAD * math.sin(steps))
        )
        return pose

    def scaled(self, mounting: Matrix) -> Walk:
        """Returns the walk with the radius that makes the camera's path `path_m` long.

        Args:
            mounting: the camera's optical frame in the head.
        """
        low, high = 0.2, 2.5
        for _ in range(40):
            middle = replace(self, radius_m=(low + high) / 2)
            is_short = _length_m(middle, mounting) < self.path_m
            low, high = (middle.radius_m, high) if is_short else (low, middle.radius_m)
        return replace(self, radius_m=high)

    def tum(self) -> Iterator[str]:
        """Yields the lines of a TUM file for the simulated headset; it first rests for REST_S."""
        for index in range(math.ceil((REST_S + self.duration_s) * _RATE_HZ) + 1):
            at_s = index / _RATE_HZ
            pose = self.head(at_s - REST_S)
            numbers = (*pose[:3, 3], *quaternion(pose))
            yield f"{at_s:.3f} {' '.join(f'{it:.12f}' for it in numbers)}\n"

    def _progress(self, at_s: float) -> float:
        """Returns the progress from 0 to 1: the integral of a speed that rises, stays and falls."""
        at_s = min(max(at_s, 0.0), self.duration_s)
        left_s = self.duration_s - at_s
        if left_s < at_s:
            return 1 - self._progress(left_s)
        if at_s < _RAMP_S:
            gone_s = at_s / 2 - _RAMP_S / (2 * math.pi) * math.sin(math.pi * at_s / _RAMP_S)
        else:
            gone_s = at_s - _RAMP_S / 2
        return gone_s / (self.duration_s - _RAMP_S)


# The thesis's trajectories, in its order.
WALKS = (
    Walk("center, 13.5 s", "world_center", 13.5, 5.3, 230),
    Walk("center, 10.9 s", "world_center", 10.9, 6.0, 250),
    Walk("left, 22.8 s, closed loop", "world_left", 22.8, 12.3, 360),
    Walk("right, 16.0 s", "world_right", 16.0, 8.0, -300),
)
THESIS_RMSE_M = (0.044, 0.075, 0.326, 0.097)


def drawn_walks(seed: int) -> tuple[Walk, Walk]:
    """Returns two walks that a seed draws, as long and as fast as the thesis's."""
    random = np.random.default_rng(seed)

    def walk(number: int) -> Walk:
        camera = str(random.choice(["world_left", "world_center", "world_right"]))
        turn_deg = float(random.choice([-1, 1]) * random.uniform(220, 350))
        path_m = abs(math.radians(turn_deg)) * float(random.uniform(1.0, 1.8))
        duration_s = round(path_m / float(random.uniform(0.4, 0.55)), 1)
        return Walk(f"seed {seed}, walk {number}", camera, duration_s, path_m, turn_deg)

    return walk(1), walk(2)


def _rotation(axis: int, angle: float) -> Matrix:
    return np.asarray(cv2.Rodrigues(np.eye(3)[axis] * angle)[0])


def _length_m(walk: Walk, mounting: Matrix) -> float:
    """Returns the length of the camera's path through its positions at 30 images per second."""
    times_s = np.arange(0, walk.duration_s + 1e-9, 1 / 30)
    places = np.array([(walk.head(at_s) @ mounting)[:3, 3] for at_s in times_s])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
