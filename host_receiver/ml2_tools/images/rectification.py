"""Images as a camera without distortion would have taken them."""

from __future__ import annotations

import functools

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.lens import Floats

_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def rectify(image: NDArray[np.uint8], camera: Camera) -> NDArray[np.uint8]:
    """An image in the geometry of `camera`'s R and P; black where the camera saw nothing.

    Raises:
        ValueError: the image has not the size of the camera's.
    """
    _check_size(image, camera)
    return cv2.remap(image, *_fixed_maps(camera), cv2.INTER_LINEAR).astype(np.uint8, copy=False)


def rectify_depth(z: Floats, camera: Camera) -> Floats:
    """Depth in the geometry of P: each pixel has the nearest measurement, or NaN.

    Raises:
        ValueError: as rectify(), or R is not the identity, under which z would be another.
    """
    _check_size(z, camera)
    if camera.rotation != _IDENTITY:
        raise ValueError("expected a depth camera's R to be the identity")
    x, y = _maps(camera)
    nan = (float("nan"),)
    return cv2.remap(z, x, y, cv2.INTER_NEAREST, borderValue=nan).astype(np.float32, copy=False)


def _check_size(image: NDArray[np.generic], camera: Camera) -> None:
    height, width = image.shape[:2]
    if (width, height) != (camera.lens.width, camera.lens.height):
        expected = f"{camera.lens.width}x{camera.lens.height}"
        raise ValueError(
            f"expected an image of {expected} as in camera_info, found {width}x{height}"
        )


@functools.lru_cache(16)
def _maps(camera: Camera) -> tuple[Floats, Floats]:
    """For each pixel of the rectified image, where it is in the camera's."""
    columns, rows = np.meshgrid(np.arange(camera.lens.width), np.arange(camera.lens.height))
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1).astype(np.float64)
    to_camera = np.array(camera.rotation).reshape(3, 3).T
    to_ray = to_camera @ np.linalg.inv(np.array(camera.matrix).reshape(3, 3))
    rays = pixels @ to_ray.T
    x, y = (rays[..., index] / rays[..., 2] for index in (0, 1))
    u, v = camera.lens.project(x.astype(np.float32), y.astype(np.float32))
    is_seen = rays[..., 2] > 0
    return tuple(np.where(is_seen & np.isfinite(it), it, np.float32(-10)) for it in (u, v))  # type: ignore[return-value]


@functools.lru_cache(16)
def _fixed_maps(camera: Camera) -> tuple[NDArray[np.int16], NDArray[np.uint16]]:
    """In 1/32 px, which OpenCV is twice as fast with."""
    return cv2.convertMaps(*_maps(camera), cv2.CV_16SC2)  # type: ignore[return-value]
