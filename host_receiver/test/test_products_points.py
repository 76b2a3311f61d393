"""A plane in front of two cameras, by OpenCV and geometry."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from ml2_tools.geometry.lens import Lens
from ml2_tools.products.points import colours_of, points_of
from ml2_tools.products.registration import register

DEPTH = Lens(272, 240, 185.0, 186.0, 135.0, 121.0, "plumb_bob", (0.1, -0.1, 1e-3, -1e-3, 0.02))
COLOR = Lens(640, 480, 600.0, 600.0, 320.0, 240.0, "plumb_bob", (0.05, -0.02, 1e-3, 1e-3, 0.0))
# Depth camera -> colour camera.
BETWEEN = np.eye(4)
BETWEEN[:3, :3] = cv2.Rodrigues(np.array([0.02, -0.05, 0.03]))[0]
BETWEEN[:3, 3] = (0.05, -0.02, 0.01)
# Points p of the wall have NORMAL @ p = OFFSET_M, in the depth camera's optical frame.
NORMAL, OFFSET_M = np.array([0.2, -0.1, 0.97]), 1.5


def directions(lens: Lens) -> NDArray[np.float64]:
    """The ray of each pixel, by OpenCV."""
    columns, rows = np.meshgrid(np.arange(lens.width), np.arange(lens.height))
    pixels = np.stack([columns, rows], -1).reshape(-1, 1, 2).astype(np.float64)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-10)
    d = np.array(lens.coefficients)
    found = cv2.undistortPointsIter(pixels, lens.matrix, d, np.eye(3), np.eye(3), stop)
    return np.concatenate([found.reshape(-1, 2), np.ones((len(pixels), 1))], axis=1)


def wall(lens: Lens, depth_to_lens: NDArray[np.float64]) -> NDArray[np.float32]:
    """z that a camera measures of the wall."""
    rotation, shift = depth_to_lens[:3, :3], depth_to_lens[:3, 3]
    normal = rotation @ NORMAL
    z: NDArray[np.float64] = (OFFSET_M + normal @ shift) / (directions(lens) @ normal)
    return z.reshape(lens.height, lens.width).astype(np.float32)


def test_points_lie_on_the_wall_behind_their_pixels() -> None:
    z = wall(DEPTH, np.eye(4))
    z[10, 20] = np.nan
    points = points_of(z, DEPTH)
    assert np.isnan(points[10, 20]).all()
    known = points[~np.isnan(z)].astype(np.float64)
    assert np.abs(known @ NORMAL - OFFSET_M).max() < 1e-4
    seen, _ = cv2.projectPoints(
        known, np.zeros(3), np.zeros(3), DEPTH.matrix, np.array(DEPTH.coefficients)
    )
    rows, columns = np.nonzero(~np.isnan(z))
    assert np.abs(seen.reshape(-1, 2) - np.stack([columns, rows], 1)).max() < 0.02


def test_a_step_leaves_rows_and_columns_out() -> None:
    z = wall(DEPTH, np.eye(4))
    np.testing.assert_array_equal(points_of(z, DEPTH, 3), points_of(z, DEPTH)[::3, ::3])


def test_each_point_has_the_colour_of_its_pixel() -> None:
    """The image says in blue and green which pixel it is, in steps of 8."""
    columns, rows = np.meshgrid(np.arange(COLOR.width) // 8, np.arange(COLOR.height) // 8)
    bgr = np.stack([columns, rows, np.full_like(rows, 200)], axis=-1).astype(np.uint8)
    points = points_of(wall(DEPTH, np.eye(4)), DEPTH)
    packed = colours_of(points, BETWEEN, COLOR, bgr).ravel()
    expected, _ = cv2.projectPoints(
        points.reshape(-1, 3).astype(np.float64),
        cv2.Rodrigues(BETWEEN[:3, :3])[0],
        BETWEEN[:3, 3],
        COLOR.matrix,
        np.array(COLOR.coefficients),
    )
    pixels = expected.reshape(-1, 2)
    inside = ((pixels > 1) & (pixels < np.array([COLOR.width, COLOR.height]) - 2)).all(axis=1)
    assert inside.sum() > 10_000
    assert (packed[inside] >> 16 == 200).all()
    found = np.stack([packed & 0xFF, packed >> 8 & 0xFF], axis=1)[inside]
    assert np.abs(found * 8 + 4 - pixels[inside]).max() < 5.1
    outside = ((pixels < -2) | (pixels > np.array([COLOR.width, COLOR.height]) + 2)).any(axis=1)
    assert outside.sum() > 1000
    assert (packed[outside] == 0).all()


def test_registered_depth_is_what_the_other_camera_would_measure() -> None:
    found = register(wall(DEPTH, np.eye(4)), DEPTH, BETWEEN, COLOR)
    expected = wall(COLOR, BETWEEN)
    known = ~np.isnan(found)
    assert known.mean() > 0.8, "it has no holes"
    # The footprint of a depth pixel, 5 px of colour, takes the nearest that is in it.
    assert np.abs(found - expected)[known].max() < 0.02
    assert (found <= expected + 5e-3)[known].all()


def test_of_two_surfaces_the_nearer_one_counts() -> None:
    z = np.full((DEPTH.height, DEPTH.width), 2, np.float32)
    z[100:140, 110:160] = 1
    shift = np.eye(4)
    shift[0, 3] = 0.2  # moves the near square by 120 px of colour, the far wall by 60
    found = register(z, DEPTH, shift, COLOR)
    near = found[176:294, 390:500]
    assert (near == 1).mean() > 0.95
    assert set(np.unique(found[~np.isnan(found)])) == {1, 2}


def test_what_is_behind_the_other_camera_is_not_seen() -> None:
    behind = np.diag([1.0, -1, -1, 1])
    z = np.ones((DEPTH.height, DEPTH.width), np.float32)
    assert np.isnan(register(z, DEPTH, behind, COLOR)).all()


def test_depth_of_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match="expected depth of 272x240, found 3x2"):
        points_of(np.zeros((2, 3), np.float32), DEPTH)
    points = points_of(np.ones((240, 272), np.float32), DEPTH)
    with pytest.raises(ValueError, match="expected an image of 640x480, found 3x2"):
        colours_of(points, BETWEEN, COLOR, np.zeros((2, 3, 3), np.uint8))
