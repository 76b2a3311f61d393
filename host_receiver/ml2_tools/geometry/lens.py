"""Lens models as functions of arrays, with values that are computed once per lens."""

import functools
import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

type Floats = NDArray[np.float32]

# The number of coefficients of each model, and the indices of the radial ones.
_COEFFICIENTS = {
    "plumb_bob": (5, (0, 1, 4)),
    "equidistant": (4, (0, 1, 2, 3)),
    "fisheye_tangential": (6, (0, 1, 2, 3)),
}
_MOST_PX = 4096
_CACHED_LENSES = 16
_ONE, _TWO = np.float32(1), np.float32(2)
_UNDISTORTION = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 40, 1e-9)


@dataclass(frozen=True)
class Lens:
    """A lens model; hashable, because maps are cached by lens.

    `model` is ROS's `plumb_bob` (k1 k2 p1 p2 k3) or `equidistant` (k1 to k4), or the world
    cameras' own `fisheye_tangential` (k1 to k4, p1, p2): equidistant, then tangential.

    Raises:
        ValueError: a value is out of range, or the number of coefficients is wrong.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    model: str
    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        if not (0 < self.width <= _MOST_PX and 0 < self.height <= _MOST_PX):
            raise ValueError(f"expected 1 to {_MOST_PX} px, found {self.width}x{self.height}")
        if self.model not in _COEFFICIENTS:
            raise ValueError(f"expected one of {', '.join(_COEFFICIENTS)}, found {self.model!r}")
        expected = _COEFFICIENTS[self.model][0]
        if len(self.coefficients) != expected:
            found = len(self.coefficients)
            raise ValueError(f"expected {expected} {self.model} coefficients, found {found}")
        numbers = (self.fx, self.fy, self.cx, self.cy, *self.coefficients)
        if not all(map(math.isfinite, numbers)) or self.fx <= 0 or self.fy <= 0:
            raise ValueError(f"expected a focal length above 0 and finite values, found {numbers}")

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The 3x3 matrix K."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])

    def project(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Returns the pixels of the points (x, y, 1); NaN outside the range of the model."""
        u: Floats
        v: Floats
        squared: Floats = x * x + y * y
        if self.model == "plumb_bob":
            k1, k2, p1, p2, k3 = map(np.float32, self.coefficients)
            radial: Floats = ((squared * k3 + k2) * squared + k1) * squared + _ONE
            dx, dy = _tangential(x, y, squared, p1, p2)
            u, v = dx + x * radial, dy + y * radial
            is_seen = squared < _reach(self) ** 2
        else:
            k1, k2, k3, k4, *tangential = map(np.float32, self.coefficients)
            radius = np.maximum(np.sqrt(squared), np.float32(1e-9))
            theta = np.arctan(radius)
            t = theta * theta
            scale = theta * (1 + t * (k1 + t * (k2 + t * (k3 + t * k4)))) / radius
            u, v = x * scale, y * scale
            if tangential:
                dx, dy = _tangential(u, v, u * u + v * v, *tangential)
                u, v = u + dx, v + dy
            is_seen = theta < _reach(self)
        u = u * np.float32(self.fx) + np.float32(self.cx)
        v = v * np.float32(self.fy) + np.float32(self.cy)
        u[~is_seen] = v[~is_seen] = np.nan
        return u, v


def _tangential(
    x: Floats, y: Floats, squared: Floats, p1: np.float32, p2: np.float32
) -> tuple[Floats, Floats]:
    product = _TWO * (x * y)
    return (
        np.add(product * p1, (squared + _TWO * (x * x)) * p2, dtype=np.float32),
        np.add((squared + _TWO * (y * y)) * p1, product * p2, dtype=np.float32),
    )


@functools.lru_cache(_CACHED_LENSES)
def _reach(lens: Lens) -> float:
    """Returns where the polynomial stops rising: a radius at depth 1, or for fisheyes an angle."""
    radial = [lens.coefficients[index] for index in _COEFFICIENTS[lens.model][1]]
    slope = [1.0, *(k * (2 * power + 3) for power, k in enumerate(radial))]
    roots = np.roots(slope[::-1])
    folds = [root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 0]
    return math.sqrt(min(folds)) if folds else math.inf


@functools.lru_cache(_CACHED_LENSES)
def rays(lens: Lens) -> tuple[Floats, Floats]:
    """Returns x and y of the ray (x, y, 1) of each pixel, each height x width.

    Raises:
        ValueError: the lens model is not one of ROS.
    """
    columns, rows = np.meshgrid(np.arange(lens.width), np.arange(lens.height))
    pixels = np.stack([columns, rows], axis=-1).reshape(-1, 1, 2).astype(np.float64)
    coefficients, none = np.array(lens.coefficients), np.eye(3)
    if lens.model == "plumb_bob":
        found = cv2.undistortPointsIter(
            pixels, lens.matrix, coefficients, none, none, _UNDISTORTION
        )
    elif lens.model == "equidistant":
        found = cv2.fisheye.undistortPoints(
            pixels, lens.matrix, coefficients, None, None, None, _UNDISTORTION
        )
    else:
        raise ValueError(f"expected a model of ROS, found {lens.model}")
    both = found.reshape(lens.height, lens.width, 2).astype(np.float32)
    return np.ascontiguousarray(both[..., 0]), np.ascontiguousarray(both[..., 1])


@functools.lru_cache(_CACHED_LENSES)
def z_per_distance(lens: Lens) -> Floats:
    """Returns, for each pixel, the ratio of z along the optical axis to the distance."""
    x, y = rays(lens)
    return (1 / np.sqrt(1 + x * x + y * y)).astype(np.float32)
