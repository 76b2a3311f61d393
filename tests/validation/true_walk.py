"""Computes the true poses of the simulated headset's camera on a walk."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from euroc import Matrix, pose_matrix
from ml2_tools.evaluation.trajectory import Trajectory
from processes import Received
from simulated_scene import TO_ROS
from simulated_truth import OPTICAL, SimulatedTruth
from transforms import moving
from walks import REST_S, Walk

_NANOS = 1_000_000_000
_STEP_NS = 5_000_000


@dataclass(frozen=True)
class TrueWalk:
    """A walk with its start time; only the second of the start comes from the headset's data.

    Attributes:
        mounting: the camera's optical frame in the head's body.
        start_ns: ROS time of the walk's start.
    """

    walk: Walk
    mounting: Matrix
    start_ns: int

    @staticmethod
    def found(
        received: Received, walk: Walk, mounting: Matrix, simulation: SimulatedTruth
    ) -> TrueWalk:
        """Finds the start: the whole second of the simulation's clock that fits the poses best."""
        frame = f"{walk.camera}_optical_frame"
        poses = {at: pose for (child, at), pose in moving(received).items() if child == frame}
        first = int(simulation.mltime_ns(min(poses)) // _NANOS)
        begins = [simulation.ros_ns(second * _NANOS) for second in range(first, first + REST_S + 2)]

        def misfit_m(it: TrueWalk) -> float:
            differences = [pose[:3, 3] - it.pose(at)[:3, 3] for at, pose in poses.items()]
            return float(np.linalg.norm(differences, axis=1).mean())

        return min((TrueWalk(walk, mounting, begin) for begin in begins), key=misfit_m)

    @property
    def end_ns(self) -> int:
        return self.start_ns + round(self.walk.duration_s * _NANOS)

    def pose(self, stamp_ns: int) -> Matrix:
        """Returns the pose of the optical frame in the world."""
        return self.walk.head((stamp_ns - self.start_ns) / _NANOS) @ self.mounting

    def trajectory(self, received: Received) -> Trajectory:
        """Returns the poses at the transforms' stamps, and every 5 ms for interpolation."""
        frame = f"{self.walk.camera}_optical_frame"
        stamps = {at for child, at in moving(received) if child == frame}
        between = range(min(stamps), max(stamps), _STEP_NS)
        return [(at, self.pose(at)) for at in sorted({*stamps, *between})]


def camera_in_head(simulation: SimulatedTruth, camera: str) -> Matrix:
    """Returns the camera's optical frame in the head's body (x forward, y left, z up)."""
    mount = json.loads(simulation.library.ml2sim_mounts())[camera]
    x, y, z, w = mount["rotation"]
    device, matrix = pose_matrix(mount["position"], w, x, y, z), np.eye(4)
    matrix[:3, :3] = TO_ROS @ device[:3, :3] @ OPTICAL
    matrix[:3, 3] = TO_ROS @ device[:3, 3]
    return matrix
