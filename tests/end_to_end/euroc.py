"""Reads an EuRoC/ASL recording as the expected data, without code of the product."""

from __future__ import annotations

import csv
from bisect import bisect
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

type Matrix = NDArray[np.float64]


def rows(recording: Path, sensor: str) -> list[list[str]]:
    """Returns the rows of data.csv without the heading; the first column is the time in ns."""
    with (recording / "mav0" / sensor / "data.csv").open() as file:
        return list(csv.reader(file))[1:]


def sensor_yaml(recording: Path, sensor: str) -> dict[str, Any]:
    """Reads sensor.yaml, whose first line is not YAML."""
    text = (recording / "mav0" / sensor / "sensor.yaml").read_text()
    parsed: dict[str, Any] = yaml.safe_load(text.replace("%YAML:1.0", ""))
    return parsed


def pose_matrix(position: Any, w: float, x: float, y: float, z: float) -> Matrix:
    """Returns a 4x4 matrix, by the quaternion's rotation vector and OpenCV's Rodrigues formula."""
    axis = np.array([x, y, z])
    sine = np.linalg.norm(axis)
    angle = 2 * np.arctan2(sine, w)
    matrix = np.eye(4)
    matrix[:3, :3] = cv2.Rodrigues(axis / sine * angle)[0] if sine else np.eye(3)
    matrix[:3, 3] = position
    return matrix


def ground_truth(recording: Path) -> dict[int, Matrix]:
    """Returns the poses of the body in the world by recorded time in ns."""
    poses = {}
    for row in rows(recording, "state_groundtruth_estimate0"):
        values = [float(value) for value in row[1:8]]
        poses[int(row[0])] = pose_matrix(values[:3], *values[3:])
    return poses


def angle_between(one: Matrix, other: Matrix) -> float:
    """Returns the angle between two rotations in rad; it must be below a right angle.

    cv2.Rodrigues is not used, because it rounds angles below 1e-5 rad to 0.
    """
    rotation = one[:3, :3].T @ other[:3, :3]
    assert np.trace(rotation) > 1
    return float(np.arcsin(np.linalg.norm(rotation - rotation.T) / np.sqrt(8)))


def interpolated(poses: dict[int, Matrix], at: int) -> Matrix:
    """Interpolates the pose at a time in ns, linearly in position and in the rotation vector."""
    if at in poses:
        return poses[at]
    stamps = sorted(poses)
    later = bisect(stamps, at)
    assert 0 < later < len(stamps), "the time is between two poses"
    before, after = stamps[later - 1 : later + 1]
    fraction = (at - before) / (after - before)
    a, b = poses[before], poses[after]
    turn = cv2.Rodrigues(a[:3, :3].T @ b[:3, :3])[0]
    matrix = np.eye(4)
    matrix[:3, :3] = a[:3, :3] @ cv2.Rodrigues(turn * fraction)[0]
    matrix[:3, 3] = a[:3, 3] + fraction * (b[:3, 3] - a[:3, 3])
    return matrix
