"""Lenses against OpenCV's models, and the world cameras against the vendor's formula."""

import dataclasses
import math
import re

import cv2
import numpy as np
import pytest

from ml2_tools.geometry.lens import Lens, rays, z_per_distance
from ml2_tools.products.registration import register

PLUMB_BOB = Lens(544, 480, 370.0, 371.0, 270.0, 241.0, "plumb_bob", (0.1, -0.2, 1e-3, -2e-3, 0.05))
EQUIDISTANT = Lens(
    1016, 1016, 580.0, 581.0, 507.0, 510.0, "equidistant", (0.02, -0.01, 3e-3, -1e-3)
)
WORLD = dataclasses.replace(
    EQUIDISTANT,
    model="fisheye_tangential",
    coefficients=(*EQUIDISTANT.coefficients, 1e-3, -2e-3),
)
GRID = np.stack(np.meshgrid(np.linspace(-0.8, 0.8, 21), np.linspace(-0.7, 0.7, 19)), -1).reshape(
    -1, 2
)
POINTS = np.concatenate([GRID, np.ones((len(GRID), 1))], axis=1)
STILL = (np.zeros(3), np.zeros(3))


def projected(lens: Lens, points: np.ndarray) -> np.ndarray:
    x, y = (points / points[:, 2:]).T.astype(np.float32)[:2]
    return np.stack(lens.project(x, y), axis=1)


def by_opencv(lens: Lens, points: np.ndarray) -> np.ndarray:
    project = cv2.projectPoints if lens.model == "plumb_bob" else cv2.fisheye.projectPoints
    d = np.array(lens.coefficients)
    seen, _ = project(points.reshape(-1, 1, 3), *STILL, lens.matrix, d)
    return np.asarray(seen.reshape(-1, 2))


@pytest.mark.parametrize("lens", [PLUMB_BOB, EQUIDISTANT])
def test_a_lens_projects_as_opencv_does(lens: Lens) -> None:
    assert np.abs(projected(lens, POINTS) - by_opencv(lens, POINTS)).max() < 1e-3


def test_a_world_camera_projects_one_point_as_its_formula_says() -> None:
    k1, k2, k3, k4, p1, p2 = WORLD.coefficients
    x, y = 0.6, -0.5
    r = math.hypot(x, y)
    theta = math.atan(r)
    scale = theta * (1 + k1 * theta**2 + k2 * theta**4 + k3 * theta**6 + k4 * theta**8) / r
    xr, yr = x * scale, y * scale
    q = xr**2 + yr**2
    expected = (
        WORLD.fx * (xr + 2 * p1 * xr * yr + p2 * (q + 2 * xr**2)) + WORLD.cx,
        WORLD.fy * (yr + p1 * (q + 2 * yr**2) + 2 * p2 * xr * yr) + WORLD.cy,
    )
    assert projected(WORLD, np.array([[x, y, 1]]))[0] == pytest.approx(expected, abs=1e-3)


def test_the_optical_axis_is_the_principal_point() -> None:
    for lens in (PLUMB_BOB, EQUIDISTANT, WORLD):
        assert projected(lens, np.array([[0.0, 0, 1]]))[0] == pytest.approx((lens.cx, lens.cy))


def test_what_the_polynomial_folds_back_is_not_seen() -> None:
    """r (1 - r^2) grows until r^2 = 1/3 and shrinks from there."""
    folding = Lens(100, 100, 50.0, 50.0, 50.0, 50.0, "plumb_bob", (-1.0, 0, 0, 0, 0))
    u, _ = folding.project(np.array([0.57, 0.59], np.float32), np.zeros(2, np.float32))
    assert np.isfinite(u[0])
    assert np.isnan(u[1])


@pytest.mark.parametrize("lens", [PLUMB_BOB, EQUIDISTANT])
def test_the_ray_of_a_pixel_is_seen_in_that_pixel(lens: Lens) -> None:
    x, y = (it.ravel()[::101].astype(np.float64) for it in rays(lens))
    points = np.stack([x, y, np.ones_like(x)], axis=1)
    rows, columns = np.divmod(np.arange(lens.width * lens.height)[::101], lens.width)
    assert np.abs(by_opencv(lens, points) - np.stack([columns, rows], axis=1)).max() < 0.01


def test_distances_along_rays_become_z() -> None:
    x, y = rays(PLUMB_BOB)
    lengths = np.linalg.norm(np.stack([x, y, np.ones_like(x)]), axis=0)
    assert np.allclose(z_per_distance(PLUMB_BOB) * lengths, 1, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"width": 0}, "expected 1 to 4096 px, found 0x480"),
        ({"height": 10**9}, "expected 1 to 4096 px, found 544x1000000000"),
        ({"model": "kannala_brandt"}, "expected one of plumb_bob, equidistant, fisheye_tangential"),
        ({"coefficients": (0.0,)}, "expected 5 plumb_bob coefficients, found 1"),
        ({"fx": 0.0}, "expected a focal length above 0 and finite values"),
        ({"cx": math.nan}, "expected a focal length above 0 and finite values"),
    ],
)
def test_values_of_no_lens_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        Lens(**{**vars(PLUMB_BOB), **change})


@pytest.mark.parametrize("focal_px", [5e-324, 1e-9, 1.0])
def test_a_lens_that_sees_next_to_everything_is_refused_before_it_takes_memory(
    focal_px: float,
) -> None:
    wide = dataclasses.replace(PLUMB_BOB, fx=focal_px, fy=focal_px, coefficients=(0.0,) * 5)
    depth = np.ones((wide.height, wide.width), np.float32)
    with pytest.raises(ValueError, match="expected at most 64 px for a depth pixel"):
        register(depth, wide, np.eye(4), PLUMB_BOB)
