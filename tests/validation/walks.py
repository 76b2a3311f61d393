"""The walks of the validation: where a head goes that walks round the room and looks about.

Each is a closed form of time, as long in seconds and metres as one of the thesis's trajectories.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np

from euroc import Matrix
from ml2_tools.evaluation.tum import quaternion

# Of the ellipse about the room's middle, across the room in parts of along it.
_WIDTH = 0.85
_GLANCE_RAD, _GLANCE_S = math.radians(20), 3.5
_NOD_RAD, _TILT_RAD = math.radians(5), math.radians(2)
_STEPS_HZ, _BOB_M, _SWAY_M = 1.8, 0.01, 0.012
_RISE_M = 0.06
# Until every stream of a headset runs; whole seconds.
REST_S = 2
# To get from rest to speed and back.
_RAMP_S = 1.0
_RATE_HZ = 100


@dataclass(frozen=True)
class Walk:
    """One of them.

    Attributes:
        camera: the one that is looked through.
        path_m: how far that camera goes.
        turn_deg: how far round the room; to the left where above 0.
        radius_m: of the ellipse, along the room.
    """

    name: str
    camera: str
    duration_s: float
    path_m: float
    turn_deg: float
    radius_m: float = 1.0

    def head(self, at_s: float) -> Matrix:
        """Of the head's body (x forward, y left, z up) in the world; it rests before and after."""
        way = self._progress(at_s)
        glances = 2 * math.pi * round(self.duration_s / _GLANCE_S) * way
        steps = 2 * math.pi * round(self.duration_s * _STEPS_HZ / 2) * way
        turn = math.radians(self.turn_deg) * way
        radius_m = self.radius_m + _SWAY_M * math.sin(steps)
        pose = np.eye(4)
        pose[:3, 3] = (
            radius_m * math.cos(turn),
            _WIDTH * radius_m * math.sin(turn),
            _RISE_M * math.sin(2 * math.pi * way) + _BOB_M * math.sin(2 * steps),
        )
        facing = turn + math.copysign(math.pi / 2, self.turn_deg)
        pose[:3, :3] = (
            _turned(2, facing + _GLANCE_RAD * math.sin(glances))
            @ _turned(1, _NOD_RAD * math.sin(glances / 2))
            @ _turned(0, _TILT_RAD * math.sin(steps))
        )
        return pose

    def scaled(self, mounting: Matrix) -> Walk:
        """With the radius that makes a camera's way `path_m` long; `mounting` is in the head."""
        low, high = 0.2, 2.5
        for _ in range(40):
            middle = replace(self, radius_m=(low + high) / 2)
            is_short = _length_m(middle, mounting) < self.path_m
            low, high = (middle.radius_m, high) if is_short else (low, middle.radius_m)
        return replace(self, radius_m=high)

    def tum(self) -> Iterator[str]:
        """Lines of a TUM file for the simulated headset, which rests for REST_S at first."""
        for index in range(math.ceil((REST_S + self.duration_s) * _RATE_HZ) + 1):
            at_s = index / _RATE_HZ
            pose = self.head(at_s - REST_S)
            numbers = (*pose[:3, 3], *quaternion(pose))
            yield f"{at_s:.3f} {' '.join(f'{it:.12f}' for it in numbers)}\n"

    def _progress(self, at_s: float) -> float:
        """Of the way, from 0 to 1: the integral of a speed that rises, stays and falls."""
        at_s = min(max(at_s, 0.0), self.duration_s)
        left_s = self.duration_s - at_s
        if left_s < at_s:
            return 1 - self._progress(left_s)
        if at_s < _RAMP_S:
            gone_s = at_s / 2 - _RAMP_S / (2 * math.pi) * math.sin(math.pi * at_s / _RAMP_S)
        else:
            gone_s = at_s - _RAMP_S / 2
        return gone_s / (self.duration_s - _RAMP_S)


# The thesis's, in its order.
WALKS = (
    Walk("center, 13.5 s", "world_center", 13.5, 5.3, 230),
    Walk("center, 10.9 s", "world_center", 10.9, 6.0, 250),
    Walk("left, 22.8 s, closed loop", "world_left", 22.8, 12.3, 360),
    Walk("right, 16.0 s", "world_right", 16.0, 8.0, -300),
)
THESIS_RMSE_M = (0.044, 0.075, 0.326, 0.097)


def _turned(axis: int, angle: float) -> Matrix:
    return np.asarray(cv2.Rodrigues(np.eye(3)[axis] * angle)[0])


def _length_m(walk: Walk, mounting: Matrix) -> float:
    """Through the camera's places at its images, 30 a second."""
    times_s = np.arange(0, walk.duration_s + 1e-9, 1 / 30)
    places = np.array([(walk.head(at_s) @ mounting)[:3, 3] for at_s in times_s])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
