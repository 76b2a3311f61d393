"""Cameras and an IMU as one body, wherever what is known of them comes from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ml2_receiver.configuration.calibration import Calibration

from .kalibr import RigCamera


@dataclass(frozen=True)
class Rig:
    """The cameras in the order asked for, at one instant, and the rate of the IMU's stamps."""

    cameras: tuple[RigCamera, ...]
    imu_rate_hz: float | None


def calibration_of(info: Any) -> Calibration:
    """What a sensor_msgs/CameraInfo says beyond its header."""
    rows = (tuple(map(float, it)) for it in (info.d, info.k, info.r, info.p))
    return Calibration(info.width, info.height, info.distortion_model, *rows)
