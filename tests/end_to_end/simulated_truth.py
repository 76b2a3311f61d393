"""Reads the true poses of the simulated headset from the simulation, by this machine's clock.

A ROS stamp is a time of CLOCK_REALTIME; the simulation uses CLOCK_BOOTTIME of the same machine.
This module converts between them with the kernel's clocks, without code of the product.
"""

from __future__ import annotations

import ctypes
import json
import time
from dataclasses import dataclass

import numpy as np

from euroc import Matrix, pose_matrix
from simulated_scene import LIBRARY, TO_ROS

# ml2sim_camera, native/sim/ml2sim.h.
_CAMERAS = {"world_left": 0, "world_right": 1, "world_center": 2, "depth": 3, "color": 4}
# From a camera's axes (x right, y down, z forward) to the device's (x right, y up, z backward).
OPTICAL = np.diag([1.0, -1.0, -1.0])
_CLOCK_WAS_SET_NS = 200_000


class _Pose(ctypes.Structure):
    _fields_ = (("rotation", ctypes.c_double * 4), ("position", ctypes.c_double * 3))

    def matrix(self) -> Matrix:
        x, y, z, w = self.rotation
        return pose_matrix(self.position, w, x, y, z)


@dataclass(frozen=True)
class SimulatedTruth:
    """The simulation in its initial state: the default seed, walk and MLTime.

    Attributes:
        boottime_ns: CLOCK_BOOTTIME minus CLOCK_REALTIME.
    """

    library: ctypes.CDLL
    boottime_ns: int

    @staticmethod
    def now() -> SimulatedTruth:
        library = ctypes.CDLL(str(LIBRARY))
        library.ml2sim_mltime_of_boottime.restype = ctypes.c_int64
        library.ml2sim_mltime_of_boottime.argtypes = [ctypes.c_int64]
        library.ml2sim_boottime_of_mltime.restype = ctypes.c_int64
        library.ml2sim_boottime_of_mltime.argtypes = [ctypes.c_int64]
        library.ml2sim_true_pose.argtypes = [
            ctypes.c_uint32,
            ctypes.c_int64,
            ctypes.POINTER(_Pose),
        ]
        library.ml2sim_mounts.restype = ctypes.c_char_p
        library.ml2sim_reset()
        return SimulatedTruth(library, _boottime_minus_realtime_ns())

    def clock_was_set(self) -> bool:
        """Returns True if this machine's clock was set meanwhile; true poses are then unknown."""
        return abs(_boottime_minus_realtime_ns() - self.boottime_ns) > _CLOCK_WAS_SET_NS

    def mltime_ns(self, stamp_ns: int) -> int:
        """Converts ROS time to the simulation's time."""
        return int(self.library.ml2sim_mltime_of_boottime(stamp_ns + self.boottime_ns))

    def ros_ns(self, mltime_ns: int) -> int:
        """Converts the simulation's time to ROS time."""
        return int(self.library.ml2sim_boottime_of_mltime(mltime_ns)) - self.boottime_ns

    def optical_frame(self, camera: str, stamp_ns: int) -> Matrix:
        """Returns the pose of a camera's optical frame in magicleap_world at a ROS time."""
        mltime = self.mltime_ns(stamp_ns)
        pose = _Pose()
        assert self.library.ml2sim_true_pose(_CAMERAS[camera], mltime, ctypes.byref(pose)) == 0
        device, matrix = pose.matrix(), np.eye(4)
        matrix[:3, :3] = TO_ROS @ device[:3, :3] @ OPTICAL
        matrix[:3, 3] = TO_ROS @ device[:3, 3]
        return matrix

    def imu_in_optical_frame(self, unit: str, camera: str) -> Matrix:
        """Returns the rotation from an IMU's axes to a camera's optical frame, 3x3."""
        mounts = json.loads(self.library.ml2sim_mounts())
        imu, optical = (
            pose_matrix(mounts[name]["position"], w, x, y, z)[:3, :3]
            for name in (unit, camera)
            for x, y, z, w in [mounts[name]["rotation"]]
        )
        return np.asarray(OPTICAL.T @ optical.T @ imu)


def _boottime_minus_realtime_ns() -> int:
    """Returns the difference of the clocks, from the fastest of many pairs of readings."""

    def read() -> tuple[int, int]:
        before = time.clock_gettime_ns(time.CLOCK_REALTIME)
        boottime = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        after = time.clock_gettime_ns(time.CLOCK_REALTIME)
        return after - before, boottime - (before + after) // 2

    return min(read() for _ in range(100))[1]
