"""The cameras and the IMU of a headset, from a recording or from live topics."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from ml2_receiver.configuration.calibration import Calibration

from ..geometry.pose import Pose
from .kalibr import RigCamera


@dataclass(frozen=True)
class Rig:
    """The cameras in the requested order, with poses at one stamp, and the IMU's rate.

    `imu_pose` is in the frame that the cameras share, as calibrated; None if it is not known.
    """

    cameras: tuple[RigCamera, ...]
    imu_rate_hz: float | None
    imu_pose: Pose | None = None


def calibration_of(info: Any) -> Calibration:
    """Returns the calibration in a sensor_msgs/CameraInfo."""
    rows = (tuple(map(float, it)) for it in (info.d, info.k, info.r, info.p))
    return Calibration(info.width, info.height, info.distortion_model, *rows)


def rate_hz(stamps_ns: Collection[int]) -> float | None:
    """Returns the rate at which a sensor measures, also if some of its messages were lost.

    None for less than two stamps.
    """
    periods_ns = np.diff(sorted(stamps_ns))
    if not periods_ns.size:
        return None
    # A lost message leaves twice the period.
    return 1e9 / float(periods_ns[periods_ns <= 1.5 * np.median(periods_ns)].mean())
