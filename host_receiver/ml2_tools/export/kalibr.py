"""Writes cameras, their poses and an IMU in Kalibr's YAML, which VIO packages read.

Formats: https://github.com/ethz-asl/kalibr/wiki/yaml-formats
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

from ml2_receiver.configuration.calibration import Calibration

from ..errors import ExportError
from ..geometry.pose import Pose

# The cameras whose lens models calibration programs know, in the order of cam0, cam1, ...
CAMERAS = ("world_left", "world_center", "world_right", "color")

# Standard gravity (CGPM 1901), in m/s^2.
GRAVITY = 9.80665

_GRID = 33
_UNDISTORTION_STEPS = 30


@dataclass(frozen=True)
class RigCamera:
    """A camera; `pose` is from its optical frame to a frame that all cameras share."""

    topic: str
    calibration: Calibration
    pose: Pose


@dataclass(frozen=True)
class ImuNoise:
    """The noise of an IMU in Kalibr's units.

    Densities are in m/s^2/sqrt(Hz) and rad/s/sqrt(Hz), random walks in m/s^3/sqrt(Hz) and
    rad/s^2/sqrt(Hz).
    """

    accelerometer_noise_density: float
    accelerometer_random_walk: float
    gyroscope_noise_density: float
    gyroscope_random_walk: float


@dataclass(frozen=True)
class Mounting:
    """The pose of a calibrated IMU, and its time.

    Attributes:
        pose: to the head, or to the frame that the cameras share.
        time_offset_s: what to add to the stamps of images for those of the IMU.
    """

    pose: Pose
    time_offset_s: float


@dataclass(frozen=True)
class MountedImu:
    """An IMU whose place among the cameras is known."""

    topic: str
    rate_hz: float
    noise: ImuNoise
    mounting: Mounting


def camchain(cameras: Sequence[RigCamera], mounting: Mounting | None = None) -> str:
    """Returns the text of camchain.yaml; T_cn_cnm1 transforms points from the previous camera.

    Args:
        mounting: of the IMU; without it, T_cam_imu and timeshift_cam_imu are absent.

    Raises:
        ExportError: Kalibr has no model for a lens.
    """
    chain: dict[str, Any] = {}
    comments = []
    for number, camera in enumerate(cameras):
        calibration = camera.calibration
        k = calibration.k
        model, coefficients, residual_px = distortion(calibration)
        row = chain[f"cam{number}"] = {
            "camera_model": "pinhole",
            "intrinsics": [k[0], k[4], k[2], k[5]],
            "distortion_model": model,
            "distortion_coeffs": coefficients,
            "resolution": [calibration.width, calibration.height],
            "rostopic": camera.topic,
        }
        if residual_px:
            comments.append(f"# cam{number}: without k3, radtan is off by {residual_px:.3g} px\n")
        if number:
            between = np.linalg.inv(camera.pose) @ cameras[number - 1].pose
            row["T_cn_cnm1"] = between.tolist()
        if mounting is not None:
            row["T_cam_imu"] = (np.linalg.inv(camera.pose) @ mounting.pose).tolist()
            row["timeshift_cam_imu"] = mounting.time_offset_s
    return "".join(comments) + _yaml(chain)


def imu(topic: str, rate_hz: float, noise: ImuNoise) -> str:
    """Returns the text of imu.yaml."""
    return _yaml(vars(noise) | {"rostopic": topic, "update_rate": round(rate_hz, 2)})


def _yaml(document: Mapping[str, Any]) -> str:
    return yaml.safe_dump(dict(document), sort_keys=False, default_flow_style=None, width=200)


def distortion(calibration: Calibration) -> tuple[str, list[float], float]:
    """Returns Kalibr's model, its coefficients and its largest error in pixels.

    Raises:
        ExportError: Kalibr has no model for the lens.
    """
    model, d, fx, fy = calibration.model, calibration.d, calibration.k[0], calibration.k[4]
    expected = {"equidistant": 4, "plumb_bob": 5}.get(model)
    if len(d) != expected or fx <= 0 or fy <= 0:
        found = f"{model!r} with {len(d)} coefficients, fx {fx}, fy {fy}"
        raise ExportError(f"expected a lens that Kalibr has a model for, found {found}")
    if model == "equidistant":
        return "equidistant", list(d), 0.0
    k1, k2, p1, p2, k3 = d
    if k3 == 0:
        return "radtan", [k1, k2, p1, p2], 0.0
    radius = _radii(calibration)
    # Fits the changes of k1 and k2 that replace k3 best; K, p1 and p2 stay.
    terms = np.stack([radius**3, radius**5], axis=1)
    wanted = k3 * radius**7
    change, *_ = np.linalg.lstsq(terms, wanted, rcond=None)
    residual_px = max(fx, fy) * float(np.abs(terms @ change - wanted).max())
    return "radtan", [k1 + float(change[0]), k2 + float(change[1]), p1, p2], residual_px


def _radii(calibration: Calibration) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Returns the distances from the optical axis, at depth 1, for a grid of pixels."""
    size, k = (calibration.width, calibration.height), calibration.k
    columns, rows = np.meshgrid(*(np.linspace(0, n - 1, _GRID) for n in size))
    u, v = (columns - k[2]) / k[0], (rows - k[5]) / k[4]
    k1, k2, p1, p2, k3 = calibration.d
    x, y = u, v
    for _ in range(_UNDISTORTION_STEPS):
        q = x * x + y * y
        radial = 1 + q * (k1 + q * (k2 + q * k3))
        dx = 2 * p1 * x * y + p2 * (q + 2 * x * x)
        dy = p1 * (q + 2 * y * y) + 2 * p2 * x * y
        x, y = (u - dx) / radial, (v - dy) / radial
    radii: np.ndarray[Any, np.dtype[np.float64]] = np.hypot(x, y).ravel()
    return radii
