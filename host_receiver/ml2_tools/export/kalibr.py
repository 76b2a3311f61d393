"""Cameras, their places and an IMU in the YAML of Kalibr, which VIO packages read.

Formats: https://github.com/ethz-asl/kalibr/wiki/yaml-formats
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

from ml2_receiver.configuration.calibration import Calibration
from ml2_receiver.errors import ExportError

from ..geometry.pose import Pose

# Those with lenses that calibration programs know, in the order they get their numbers.
CAMERAS = ("world_left", "world_center", "world_right", "color")

_GRID = 33
_UNDISTORTION_STEPS = 30


@dataclass(frozen=True)
class RigCamera:
    """A camera and where it was; `pose` is from its optical frame to any frame all share."""

    topic: str
    calibration: Calibration
    pose: Pose


@dataclass(frozen=True)
class ImuNoise:
    """Of an IMU, as Kalibr has it: densities in m/s^2/sqrt(Hz) and rad/s/sqrt(Hz), walks in
    m/s^3/sqrt(Hz) and rad/s^2/sqrt(Hz).
    """

    accelerometer_noise_density: float
    accelerometer_random_walk: float
    gyroscope_noise_density: float
    gyroscope_random_walk: float


def camchain(cameras: Sequence[RigCamera]) -> str:
    """camchain.yaml: cam0 is the first; T_cn_cnm1 takes points from the camera before it.

    T_cam_imu is absent: nobody knows it before a calibration.

    Raises:
        ExportError: Kalibr has no model for a lens.
    """
    chain: dict[str, Any] = {}
    comments = []
    for number, camera in enumerate(cameras):
        it = camera.calibration
        model, coefficients, residual_px = distortion(it)
        row = chain[f"cam{number}"] = {
            "camera_model": "pinhole",
            "intrinsics": [it.k[0], it.k[4], it.k[2], it.k[5]],
            "distortion_model": model,
            "distortion_coeffs": coefficients,
            "resolution": [it.width, it.height],
            "rostopic": camera.topic,
        }
        if residual_px:
            comments.append(f"# cam{number}: without k3, radtan is off by {residual_px:.3g} px\n")
        if number:
            between = np.linalg.inv(camera.pose) @ cameras[number - 1].pose
            row["T_cn_cnm1"] = between.tolist()
    return "".join(comments) + _yaml(chain)


def imu(topic: str, rate_hz: float, noise: ImuNoise) -> str:
    """imu.yaml."""
    return _yaml(vars(noise) | {"rostopic": topic, "update_rate": round(rate_hz, 2)})


def _yaml(document: Mapping[str, Any]) -> str:
    return yaml.safe_dump(dict(document), sort_keys=False, default_flow_style=None, width=200)


def distortion(it: Calibration) -> tuple[str, list[float], float]:
    """Kalibr's model and coefficients, and by how many pixels they miss at most."""
    expected = {"equidistant": 4, "plumb_bob": 5}.get(it.model)
    if len(it.d) != expected or it.k[0] <= 0 or it.k[4] <= 0:
        found = f"{it.model!r} with {len(it.d)} coefficients, fx {it.k[0]}, fy {it.k[4]}"
        raise ExportError(f"expected a lens that Kalibr has a model for, found {found}")
    if it.model == "equidistant":
        return "equidistant", list(it.d), 0.0
    k1, k2, p1, p2, k3 = it.d
    if k3 == 0:
        return "radtan", [k1, k2, p1, p2], 0.0
    radius = _radii(it)
    # With K, p1 and p2 held: the k1 and k2 whose difference is nearest to what k3 does.
    terms = np.stack([radius**3, radius**5], axis=1)
    wanted = k3 * radius**7
    change, *_ = np.linalg.lstsq(terms, wanted, rcond=None)
    residual_px = max(it.k[0], it.k[4]) * float(np.abs(terms @ change - wanted).max())
    return "radtan", [k1 + float(change[0]), k2 + float(change[1]), p1, p2], residual_px


def _radii(it: Calibration) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Distances from the optical axis, at depth 1, of what a grid over the image shows."""
    columns, rows = np.meshgrid(*(np.linspace(0, n - 1, _GRID) for n in (it.width, it.height)))
    u, v = (columns - it.k[2]) / it.k[0], (rows - it.k[5]) / it.k[4]
    k1, k2, p1, p2, k3 = it.d
    x, y = u, v
    for _ in range(_UNDISTORTION_STEPS):
        q = x * x + y * y
        radial = 1 + q * (k1 + q * (k2 + q * k3))
        dx = 2 * p1 * x * y + p2 * (q + 2 * x * x)
        dy = p1 * (q + 2 * y * y) + 2 * p2 * x * y
        x, y = (u - dx) / radial, (v - dy) / radial
    radii: np.ndarray[Any, np.dtype[np.float64]] = np.hypot(x, y).ravel()
    return radii
