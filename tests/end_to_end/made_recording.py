"""Makes a short EuRoC/ASL data set of a head that sways before a textured wall."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

_START_NS = 1_500_000_000_123_456_789
_IMAGES = 40
_IMAGE_PERIOD_NS = 50_000_000
_IMU_PERIOD_NS = 5_000_000
_WIDTH, _HEIGHT = 752, 480
# T_BS: the optical axes x, y, z in the body (x forward, y left, z up), and the place in metres.
_LEFT = [0, 0, 1, 0.05, -1, 0, 0, 0.06, 0, -1, 0, 0.01, 0, 0, 0, 1]
_RIGHT = [0, 0, 1, 0.05, -1, 0, 0, -0.05, 0, -1, 0, 0.01, 0, 0, 0, 1]
_TRUTH = "#time(ns),px,py,pz,qw,qx,qy,qz,vx,vy,vz,bwx,bwy,bwz,bax,bay,baz"
_IMU = "#timestamp [ns],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1],"
_IMU += "a_x [m s^-2],a_y [m s^-2],a_z [m s^-2]"


def write_recording(folder: Path) -> Path:
    """Writes FOLDER/mav0 with two cameras, an IMU and poses, 2 s long; returns `folder`."""
    mav = folder / "mav0"
    stamps = [_START_NS + n * _IMAGE_PERIOD_NS for n in range(_IMAGES)]
    wall = _wall()
    _write_camera(mav / "cam0", stamps, _LEFT, [458.654, 457.296, 367.215, 248.375], wall)
    _write_camera(mav / "cam1", stamps, _RIGHT, [457.587, 456.134, 379.999, 255.238], wall[::-1])
    readings = range(_START_NS, stamps[-1] + 1, _IMU_PERIOD_NS)
    _write_csv(mav / "imu0", _IMU, [[at, *_inertial(at)] for at in readings])
    _write_csv(mav / "state_groundtruth_estimate0", _TRUTH, [[at, *_pose(at)] for at in stamps])
    return folder


def _seconds(at_ns: int) -> float:
    return (at_ns - _START_NS) * 1e-9


def _yaw(at_ns: int) -> float:
    return 0.3 * float(np.sin(2 * _seconds(at_ns)))


def _pose(at_ns: int) -> list[float]:
    t, half = _seconds(at_ns), _yaw(at_ns) / 2
    return [0.1 * np.sin(t), 0.2 * t, 1.5, np.cos(half), 0.0, 0.0, np.sin(half), *9 * [0.0]]


def _inertial(at_ns: int) -> list[float]:
    t = _seconds(at_ns)
    return [0.0, 0.001, 0.6 * np.cos(2 * t), -0.1 * np.sin(t), 0.02, 9.81]


def _wall() -> NDArray[np.uint8]:
    noise = np.random.default_rng(7).integers(0, 256, (_HEIGHT, 2 * _WIDTH), np.uint8)
    return np.asarray(cv2.GaussianBlur(noise, (0, 0), 4) // 2 + 60, np.uint8)


def _write_camera(
    folder: Path,
    stamps: list[int],
    mounting: list[float],
    lens: list[float],
    wall: NDArray[np.uint8],
) -> None:
    (folder / "data").mkdir(parents=True)
    for at in stamps:
        left = _WIDTH // 2 + round(_yaw(at) * 400)
        image = np.ascontiguousarray(wall[:, left : left + _WIDTH])
        assert cv2.imwrite(str(folder / "data" / f"{at}.png"), image)
    (folder / "sensor.yaml").write_text(
        f"""%YAML:1.0
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: {mounting}
rate_hz: 20
resolution: [{_WIDTH}, {_HEIGHT}]
camera_model: pinhole
intrinsics: {lens}
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]
"""
    )
    _write_csv(folder, "#timestamp [ns],filename", [[at, f"{at}.png"] for at in stamps])


def _write_csv(folder: Path, heading: str, rows: list[list[object]]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    lines = [heading, *(",".join(map(str, row)) for row in rows)]
    (folder / "data.csv").write_text("\n".join(lines) + "\n")
