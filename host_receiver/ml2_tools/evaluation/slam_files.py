"""Reads trajectories that SLAM programs wrote for exported or played recordings."""

from pathlib import Path

import numpy as np

from ..geometry.pose import Pose
from .trajectory import Trajectory
from .tum import nanos_of, pose_of_words, read_rows, tum_row

# The year 2001 in ns. As seconds it is later than any stamp.
_LEAST_NS = 10**18
# OpenVINS's total state (RosVisualizerHelper.h): time, q p v bg ba of the IMU, time offset, number
# of cameras, then for the first camera 8 lens values, and q and p of the IMU in the camera's frame.
_STATE_COLUMNS = 34


def read_trajectory(path: Path) -> Trajectory:
    """Reads the poses of a camera's optical frame, by rising stamp.

    Detects the format by the columns:
    - ORB-SLAM3's CameraTrajectory.txt and KeyFrameTrajectory.txt of EuRoC data without an IMU:
      nanoseconds, position, quaternion
    - OpenVINS's total state with one or more cameras; the first camera's poses are read
    - TUM files

    Raises:
        EvaluationError: the file cannot be read, or has another format.
    """
    return read_rows(path, _row)


def _row(words: list[str]) -> tuple[int, Pose]:
    if len(words) >= _STATE_COLUMNS:
        return nanos_of(words[0]), _open_vins_camera(words)
    if len(words) == 8 and float(words[0]) >= _LEAST_NS:
        return int(words[0].partition(".")[0]), pose_of_words(words[1:4], words[4:])
    if len(words) == 8:
        return tum_row(words)
    expected = f"expected 8 numbers, or {_STATE_COLUMNS} and more of OpenVINS's total state"
    raise ValueError(f"{expected}, found {len(words)} words")


def _open_vins_camera(words: list[str]) -> Pose:
    """Returns the first camera's pose of a row of OpenVINS's total state.

    OpenVINS's quaternions are JPL's, from the first frame to the second. The same numbers as a
    Hamilton quaternion are the rotation from the second frame to the first.
    """
    imu = pose_of_words(words[5:8], words[1:5])
    to_imu = pose_of_words(words[31:34], words[27:31])
    camera_in_imu: Pose = np.eye(4)
    camera_in_imu[:3, :3] = to_imu[:3, :3]
    camera_in_imu[:3, 3] = -to_imu[:3, :3] @ to_imu[:3, 3]
    camera: Pose = imu @ camera_in_imu
    return camera
