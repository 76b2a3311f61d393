"""Images of a textured room through a fisheye of OpenCV's, for tests of what sees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ml2_tools.geometry.camera import Camera
from ml2_tools.geometry.lens import Lens

SIDE_PX = 400
FOCAL_PX = 230.0
CENTRE_PX = (SIDE_PX - 1) / 2
DISTORTION = (0.02, -0.01, 0.003, -0.0005)
PERIOD_NS = 33_333_333
_MATRIX = np.array([[FOCAL_PX, 0, CENTRE_PX], [0, FOCAL_PX, CENTRE_PX], [0, 0, 1]])
_HALF_ROOM_M = np.array([3.0, 1.5, 3.5])
_TEXELS, _TEXELS_PER_M = 2048, 200
_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
CAMERA = Camera(
    Lens(SIDE_PX, SIDE_PX, FOCAL_PX, FOCAL_PX, CENTRE_PX, CENTRE_PX, "equidistant", DISTORTION),
    _IDENTITY,
    tuple(_MATRIX.ravel().tolist()),
)

type Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Walk:
    """Poses of the optical frame (y down) at 30 Hz, in a room whose centre is the origin."""

    poses: list[Floats]

    @classmethod
    def about(cls, seconds: float) -> Walk:
        """Along a circle, looking about, up and down."""
        return cls([_pose(n / 30) for n in range(round(30 * seconds))])

    def stamps_ns(self) -> list[int]:
        return [n * PERIOD_NS for n in range(len(self.poses))]

    def images(self) -> Iterator[tuple[int, NDArray[np.uint8]]]:
        texture, rays = _texture(), _rays()
        for stamp_ns, pose in zip(self.stamps_ns(), self.poses, strict=True):
            yield stamp_ns, _image(texture, rays, pose)


def _pose(time_s: float) -> Floats:
    """0.6 m/s, up to 60 degrees/s."""
    pose = np.eye(4)
    turn = np.array([0.1 * np.sin(2 * time_s), 0.5 * np.sin(2 * time_s), 0.05 * np.sin(time_s)])
    pose[:3, :3] = cv2.Rodrigues(turn)[0]
    pose[:3, 3] = np.cos(time_s), 0.1 * np.sin(3 * time_s), np.sin(time_s)
    pose[:3, 3] *= 0.6
    return pose


def _rays() -> Floats:
    columns, rows = np.meshgrid(np.arange(SIDE_PX), np.arange(SIDE_PX))
    pixels = np.stack([columns, rows], -1).reshape(-1, 1, 2).astype(np.float64)
    found = cv2.fisheye.undistortPoints(pixels, _MATRIX, np.array(DISTORTION))[:, 0]
    return np.hstack([found, np.ones((len(found), 1))])


def _texture() -> NDArray[np.uint8]:
    """Noise at several scales."""
    random, total = np.random.default_rng(1), np.zeros((_TEXELS, _TEXELS))
    for cell in (8, 32, 128):
        noise = random.random((_TEXELS // cell, _TEXELS // cell))
        total += cv2.resize(noise, (_TEXELS, _TEXELS), interpolation=cv2.INTER_CUBIC)
    return cv2.normalize(total, np.empty(0), 0, 255, cv2.NORM_MINMAX).astype(np.uint8)


def _image(texture: NDArray[np.uint8], rays: Floats, pose: Floats) -> NDArray[np.uint8]:
    """Returns the picture: each ray shows the first wall that it meets."""
    directions, origin = rays @ pose[:3, :3].T, pose[:3, 3]
    with np.errstate(divide="ignore"):
        distances = (np.sign(directions) * _HALF_ROOM_M - origin) / directions
    axis = distances.argmin(axis=1)
    hit = origin + directions * distances.min(axis=1, keepdims=True)
    number = 2 * axis + (np.take_along_axis(directions, axis[:, None], 1)[:, 0] > 0)
    across = np.where(axis == 0, hit[:, 2], hit[:, 0])
    down = np.where(axis == 1, hit[:, 2], hit[:, 1])
    x, y = (
        ((it + 5) * _TEXELS_PER_M + 331 * number).astype(np.float32).reshape(SIDE_PX, SIDE_PX)
        for it in (across, down)
    )
    shown = cv2.remap(texture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    return shown.astype(np.uint8, copy=False)
