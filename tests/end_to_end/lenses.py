"""Projects points in the optical frame to pixels, by the definitions of the lens models."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

type Points = NDArray[np.float64]


def project_device(intrinsics: dict[str, Any], points: Points) -> Points:
    """Projects with the device's own model in a metadata topic."""
    fx, fy = intrinsics["focal_length"]
    cx, cy = intrinsics["principal_point"]
    coefficients = intrinsics["distortion"]
    if intrinsics["distortion_model"] == "plumb_bob":
        matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        return _flat(cv2.projectPoints(points, *_NO_POSE, matrix, np.array(coefficients)))
    assert intrinsics["distortion_model"] == "fisheye_tangential"
    x, y = fisheye_tangential(points, *coefficients)
    return np.stack([fx * x + cx, fy * y + cy], axis=1)


def fisheye_tangential(
    points: Points, k1: float, k2: float, k3: float, k4: float, p1: float, p2: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Applies the equidistant model, then tangential distortion; returns x and y at depth 1."""
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r = np.hypot(x, y)
    theta = np.arctan(r)
    theta_d = theta * (1 + k1 * theta**2 + k2 * theta**4 + k3 * theta**6 + k4 * theta**8)
    xr, yr = x * theta_d / r, y * theta_d / r
    q = xr**2 + yr**2
    return (
        xr + 2 * p1 * xr * yr + p2 * (q + 2 * xr**2),
        yr + p1 * (q + 2 * yr**2) + 2 * p2 * xr * yr,
    )


def project_ros(info: Any, points: Points) -> Points:
    """Projects with a CameraInfo, as image_geometry does."""
    matrix, coefficients = np.array(info.k).reshape(3, 3), np.array(info.d)
    if info.distortion_model == "equidistant":
        rays = points.reshape(-1, 1, 3)
        return _flat(cv2.fisheye.projectPoints(rays, *_NO_POSE, matrix, coefficients))
    assert info.distortion_model == "plumb_bob"
    return _flat(cv2.projectPoints(points, *_NO_POSE, matrix, coefficients))


_NO_POSE = (np.zeros(3), np.zeros(3))


def _flat(projected: tuple[Any, ...]) -> Points:
    pixels: Points = projected[0].reshape(-1, 2)
    return pixels
