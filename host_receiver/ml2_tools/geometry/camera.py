"""A camera's model from its CameraInfo and its metadata."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from .lens import Lens


@dataclass(frozen=True)
class Camera:
    """A camera's lens and the geometry of its rectified image.

    Attributes:
        lens: the lens with its distortion.
        rotation: R of the rectified image, row by row.
        matrix: the left 3x3 of P of the rectified image, row by row.
    """

    lens: Lens
    rotation: tuple[float, ...]
    matrix: tuple[float, ...]


def camera_of(info: Any, metadata: str | None = None) -> Camera:
    """Returns the camera of a sensor_msgs/CameraInfo.

    `metadata` of the same capture has the device's exact lens. It is used if its intrinsics are
    those of K. Another K is a calibration by the user, which takes precedence.

    Raises:
        ValueError: a message is invalid.
    """
    k, p = list(info.k), list(info.p)
    rotation = tuple(map(float, info.r))
    matrix = tuple(float(p[index]) for index in (0, 1, 2, 4, 5, 6, 8, 9, 10))
    if not np.isfinite([*rotation, *matrix]).all() or matrix[0] <= 0 or matrix[4] <= 0:
        raise ValueError(f"expected finite R and P with focal lengths above 0, found {p}")
    if info.binning_x > 1 or info.binning_y > 1 or info.roi.width or info.roi.height:
        raise ValueError("expected the whole image, found binning or a region of interest")
    lens = Lens(
        int(info.width),
        int(info.height),
        float(k[0]),
        float(k[4]),
        float(k[2]),
        float(k[5]),
        str(info.distortion_model),
        tuple(map(float, info.d)),
    )
    if metadata is not None:
        own = _device_lens(metadata)
        pinhole = (own.width, own.height, own.fx, own.fy, own.cx, own.cy)
        if pinhole == (lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy):
            lens = own
    return Camera(lens, rotation, matrix)


def metadata_stamp_ns(metadata: str) -> int:
    """Returns the stamp of a capture in ns.

    Raises:
        ValueError: the metadata have no stamp.
    """
    try:
        stamp = json.loads(metadata)["stamp"]
        return int(stamp["sec"]) * 1_000_000_000 + int(stamp["nanosec"])
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise ValueError(f"metadata without a stamp: {_short(error)}") from error


def _device_lens(metadata: str) -> Lens:
    try:
        values = json.loads(metadata)["intrinsics"]
        fx, fy = map(float, values["focal_length"])
        cx, cy = map(float, values["principal_point"])
        coefficients = tuple(map(float, values["distortion"]))
        width, height = int(values["width"]), int(values["height"])
        return Lens(width, height, fx, fy, cx, cy, str(values["distortion_model"]), coefficients)
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise ValueError(f"metadata without intrinsics: {_short(error)}") from error


def _short(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"[:200]
