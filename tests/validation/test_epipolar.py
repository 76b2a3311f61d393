"""Matches of images of a known scene are at the epipolar lines of the true poses, and no others."""

from itertools import islice

import cv2
import numpy as np
import pytest

from epipolar import epipolar_errors_px
from matching import MATCHERS
from ml2_tools.geometry.camera import Camera
from ml2_tools.geometry.lens import Lens
from ml2_tools.geometry.pose import Pose
from wall_walk import EQUIDISTANT, MATRIX, SIZE, images, trajectory

COUNT, STEP = 25, 6
FOCAL = MATRIX[0, 0], MATRIX[1, 1], MATRIX[0, 2], MATRIX[1, 2]
LENS = Lens(*SIZE, *FOCAL, "equidistant", EQUIDISTANT)


def turned(angle_deg: float) -> Pose:
    """Returns a rotation around the axis to the right."""
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(np.array([np.radians(angle_deg), 0, 0]))[0]
    return pose


def median_px(kind: str, pitch_deg: float = 0.0, rotation: Pose | None = None) -> float:
    """Returns the median error of images.

    Args:
        pitch_deg: an error of every second pose.
        rotation: R of the rectified images.
    """
    camera = Camera(
        LENS,
        tuple((np.eye(4) if rotation is None else rotation)[:3, :3].ravel()),
        tuple(MATRIX.ravel()),
    )
    poses = dict(islice(trajectory(COUNT), 0, None, STEP))
    for stamp_ns in [*poses][::2]:
        poses[stamp_ns] = poses[stamp_ns] @ turned(pitch_deg)
    some = islice(images(COUNT), 0, None, STEP)
    errors_px = epipolar_errors_px(some, camera, poses, MATCHERS[kind])
    assert len(errors_px) > 100
    return float(np.median(errors_px))


@pytest.mark.parametrize(("kind", "most_px"), [("sift", 0.3), ("orb", 1.0), ("flow", 0.3)])
def test_matches_are_at_the_lines_of_true_poses(kind: str, most_px: float) -> None:
    assert median_px(kind) < most_px


def test_images_may_be_rectified_to_another_direction() -> None:
    assert median_px("sift", rotation=turned(10.0)) < 0.3


@pytest.mark.parametrize("kind", MATCHERS)
def test_a_wrong_pose_moves_the_lines(kind: str) -> None:
    """An error of 1 degree moves the lines of a path to the right by 3 px."""
    assert median_px(kind, pitch_deg=1.0) > 1.5


@pytest.mark.parametrize("kind", MATCHERS)
def test_images_from_one_place_have_no_lines(kind: str) -> None:
    camera = Camera(LENS, tuple(np.eye(3).ravel()), tuple(MATRIX.ravel()))
    one, other = islice(images(2), 2)
    poses = {one[0]: np.eye(4), other[0]: np.eye(4)}
    assert len(epipolar_errors_px([one, other], camera, poses, MATCHERS[kind])) == 0


@pytest.mark.parametrize("kind", MATCHERS)
def test_an_image_without_texture_has_no_matches(kind: str) -> None:
    grey = np.full(SIZE[::-1], 128, np.uint8)
    describe, match = MATCHERS[kind]
    one, other = match(describe(grey), describe(grey))
    assert (one.shape, other.shape) == ((0, 2), (0, 2))
