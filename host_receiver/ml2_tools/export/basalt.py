"""Writes a calibration for Basalt, whose programs read an EuRoC folder.

Format: data/t265_kb4_calib.json in https://github.com/VladyslavUsenko/basalt
"""

from collections.abc import Sequence

import numpy as np

from ml2_receiver.json_text import json_text

from ..errors import ExportError
from ..geometry.pose import Pose, quaternion_of
from .kalibr import MountedImu, RigCamera, distortion

# Bias, and scale and misalignment of the axes, of which nothing is known.
_ACCELEROMETER, _GYROSCOPE = [0.0] * 9, [0.0] * 12


def calibration(cameras: Sequence[RigCamera], imu: MountedImu) -> str:
    """Returns the text of the calibration.

    Raises:
        ExportError: Basalt has no model for a lens.
    """
    noise = imu.noise
    value = {
        "T_imu_cam": [_pose(np.linalg.inv(imu.mounting.pose) @ it.pose) for it in cameras],
        "intrinsics": [_intrinsics(it) for it in cameras],
        "resolution": [[it.calibration.width, it.calibration.height] for it in cameras],
        "calib_accel_bias": _ACCELEROMETER,
        "calib_gyro_bias": _GYROSCOPE,
        "imu_update_rate": imu.rate_hz,
        "accel_noise_std": [noise.accelerometer_noise_density] * 3,
        "gyro_noise_std": [noise.gyroscope_noise_density] * 3,
        "accel_bias_std": [noise.accelerometer_random_walk] * 3,
        "gyro_bias_std": [noise.gyroscope_random_walk] * 3,
        "cam_time_offset_ns": round(imu.mounting.time_offset_s * 1e9),
        "vignette": [],
    }
    return json_text({"value0": value}, indent=4) + "\n"


def _pose(pose: Pose) -> dict[str, float]:
    x, y, z = map(float, pose[:3, 3])
    qx, qy, qz, qw = quaternion_of(pose)
    return {"px": x, "py": y, "pz": z, "qx": qx, "qy": qy, "qz": qz, "qw": qw}


def _intrinsics(camera: RigCamera) -> dict[str, object]:
    model, coefficients, _ = distortion(camera.calibration)
    if model != "equidistant":
        raise ExportError(f"Basalt has no model for the lens of {camera.topic}, which is {model}")
    k = camera.calibration.k
    values = {"fx": k[0], "fy": k[4], "cx": k[2], "cy": k[5]}
    values |= zip(("k1", "k2", "k3", "k4"), coefficients, strict=True)
    return {"camera_type": "kb4", "intrinsics": values}
