"""The cameras and the IMU of a headset, from a recording or from live topics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ml2_receiver.configuration.calibration import Calibration

from .kalibr import RigCamera


@dataclass(frozen=True)
class Rig:
    """The cameras in the requested order, with poses at one stamp, and the IMU's rate."""

    cameras: tuple[RigCamera, ...]
    imu_rate_hz: float | None


def calibration_of(info: Any) -> Calibration:
    """Returns the calibration in a sensor_msgs/CameraInfo."""
    rows = (tuple(map(float, it)) for it in (info.d, info.k, info.r, info.p))
    return Calibration(info.width, info.height, info.distortion_model, *rows)
