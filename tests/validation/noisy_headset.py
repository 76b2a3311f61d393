"""Reads noisy measurements of the simulated headset straight from the simulation, at any time."""

import ctypes
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from head_motion import HeadMotion
from ml2_tools.calibration.motion import HeadPoses, Samples, UnitMotion
from simulated_scene import TO_ROS
from simulated_truth import SimulatedTruth

type Floats = NDArray[np.float64]

IMU_HZ = 200
_POSE_HZ = 60
# ml2sim_unit, native/sim/ml2sim.h
# Native structures: native/sdk/ml_world_camera.h.
_CENTER, _NORMAL_EXPOSURE = 4, 2
_STAMP_AT, _PICTURE_AT, _DATA_AT = 16, 136, 160
# Captures of the world cameras are delivered after 9 ms.
_BEFORE_NS, _AFTER_NS = 20_000_000, 15_000_000
_UNITS = {"imu_left": 0, "imu_right": 1, "imu_compute_pack": 2}
_NANOS = 1_000_000_000
_TUM_HZ = 100
# Times begin so long after the path does: there it begins to move at once.
_MARGIN_S = 1
# A smoothed pose is the mean of so many poses, a millisecond apart.
_POSES_PER_S = 1000


@dataclass(frozen=True)
class Mount:
    """The mount of a unit on the head, whose axes are those of ROS."""

    rotation: Rotation
    translation_m: Floats
    late_s: float


class NoisyHeadset:
    """The simulation, whose head moves along a TUM file; only one exists in a process.

    Args:
        keys: more keys of the simulation.
    """

    def __init__(self, path: Path, **keys: int) -> None:
        self._library = library = SimulatedTruth.now().library
        library.ml2sim_set.restype = ctypes.c_char_p
        library.ml2sim_imu.argtypes = [ctypes.c_uint32, ctypes.c_int64, *[ctypes.c_void_p] * 3]
        library.ml2sim_reported_head.argtypes = [ctypes.c_int64, ctypes.c_void_p]
        for key, value in {"clock": "manual", "trajectory": path, **keys}.items():
            problem = library.ml2sim_set(key.encode(), str(value).encode())
            assert problem is None, problem.decode()
        # The first picture of a camera starts the path, at the next whole second.
        request, frame = (ctypes.c_uint32 * 4)(640, 480, 30, 0), (ctypes.c_int64 * 16)()
        library.ml2sim_now_boottime.restype = ctypes.c_int64
        now_ns = library.ml2sim_now_boottime()
        library.ml2sim_color.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p]
        assert library.ml2sim_color(request, now_ns, frame) == 0
        start_ns = (library.ml2sim_mltime_of_boottime(now_ns) // _NANOS + 1 + _MARGIN_S) * _NANOS
        self._start_ns = library.ml2sim_boottime_of_mltime(start_ns)

    def mount(self, unit: str) -> Mount:
        found = json.loads(self._library.ml2sim_mounts())[unit]
        rotation = Rotation.from_matrix(TO_ROS) * Rotation.from_quat(found["rotation"])
        return Mount(rotation, TO_ROS @ np.array(found["position"]), found["late_s"])

    def inertial(self, unit: str, duration_s: float) -> tuple[Floats, Floats]:
        """Returns stamps in s, and for each m/s^2 and rad/s in the unit's axes, at IMU_HZ."""
        stamps_ns = range(0, round(duration_s * _NANOS), _NANOS // IMU_HZ)
        values = np.empty((len(stamps_ns), 6), np.float32)
        for index, at_ns in enumerate(stamps_ns):
            force = values.ctypes.data + index * values.strides[0]
            turn = force + 3 * values.itemsize
            self._library.ml2sim_imu(_UNITS[unit], self._start_ns + at_ns, force, turn, None)
        return np.array(stamps_ns) / _NANOS, values.astype(float)

    def motion(self, unit: str, duration_s: float, smoothing_s: float = 0.0) -> UnitMotion:
        """Returns what `calibrate imu` sees in a recording.

        Args:
            smoothing_s: how old the mean is which head tracking reports instead of its poses.
        """
        stamps_s, values = self.inertial(unit, duration_s)
        poses_s = np.arange(0, duration_s, 1 / _POSE_HZ)
        ages_s = np.arange(0, 2 * smoothing_s + 1e-9, 1 / _POSES_PER_S)
        seen = [self._pose(at_s - ages_s) for at_s in poses_s]
        positions, rotations = np.array([it for it, _ in seen]), [it for _, it in seen]
        return UnitMotion(
            HeadPoses(poses_s, positions, Rotation.concatenate(rotations)),
            Samples(stamps_s, values[:, 3:]),
            Samples(stamps_s, values[:, :3]),
        )

    def light(self, times_s: Floats) -> Floats:
        """Returns the ambient light in lux."""
        self._library.ml2sim_light.restype = ctypes.c_float
        self._library.ml2sim_light.argtypes = [ctypes.c_int64]
        at_ns = [self._start_ns + round(it * _NANOS) for it in times_s]
        return np.array([self._library.ml2sim_light(it) for it in at_ns])

    def world_center(self, at_s: float) -> Floats:
        """Returns the grey levels of a capture; each call has a later time."""
        library, capture_ns = self._library, self._start_ns + round(at_s * _NANOS)
        library.ml2sim_advance.argtypes = [ctypes.c_int64]
        library.ml2sim_advance(capture_ns - _BEFORE_NS - library.ml2sim_now_boottime())
        camera = ctypes.c_uint64()
        settings = (ctypes.c_uint32 * 3)(1, _NORMAL_EXPOSURE, _CENTER)
        assert library.MLWorldCameraConnect(settings, ctypes.byref(camera)) == 0
        library.ml2sim_advance(_BEFORE_NS + _AFTER_NS)
        data = (ctypes.c_uint64 * 2)(1, 0)
        filled = ctypes.byref(ctypes.pointer(data))
        assert (
            library.MLWorldCameraGetLatestWorldCameraData(camera, ctypes.c_uint64(0), filled) == 0
        )
        frame = data[1]
        stamp_ns = ctypes.c_int64.from_address(frame + _STAMP_AT).value
        assert abs(library.ml2sim_boottime_of_mltime(stamp_ns) - capture_ns) < _NANOS / 100
        width, height, stride = (ctypes.c_uint32 * 3).from_address(frame + _PICTURE_AT)
        pixels = ctypes.c_uint64.from_address(frame + _DATA_AT).value
        rows = np.array((ctypes.c_uint8 * (stride * height)).from_address(pixels), float)
        assert library.MLWorldCameraReleaseCameraData(camera, data) == 0
        assert library.MLWorldCameraDisconnect(camera) == 0
        return rows.reshape(height, stride)[:, :width]

    def _pose(self, times_s: Sequence[float] | Floats) -> tuple[Floats, Rotation]:
        """Returns the mean of the reported poses at some times, in ROS's axes."""
        poses = np.empty((len(times_s), 7))
        for at_s, pose in zip(times_s, poses, strict=True):
            at_ns = self._start_ns + round(at_s * _NANOS)
            mltime = self._library.ml2sim_mltime_of_boottime(at_ns)
            self._library.ml2sim_reported_head(mltime, pose.ctypes.data)
        to_ros = Rotation.from_matrix(TO_ROS)
        rotation = to_ros * Rotation.from_quat(poses[:, :4]).mean() * to_ros.inv()
        return TO_ROS @ poses[:, 4:].mean(0), rotation


def write_path(path: Path, motion: HeadMotion, duration_s: float) -> None:
    """Writes a drawn motion as a TUM file, for NoisyHeadset."""
    times_s = np.arange(0, duration_s + 2 * _MARGIN_S, 1 / _TUM_HZ)
    rows = np.column_stack(
        [times_s, motion.positions(times_s), motion.rotations(times_s).as_quat()]
    )
    np.savetxt(path, rows, fmt="%.12f")
