"""The visual odometry, on images whose true poses are known."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from ml2_receiver.errors import EvaluationError
from ml2_tools.evaluation.estimator import Trajectory
from ml2_tools.evaluation.landmarks import Landmarks
from ml2_tools.evaluation.odometry import odometry
from rendered_room import CAMERA, PERIOD_NS, SIDE_PX, Walk

WALK = Walk.about(3)


@pytest.fixture(scope="module")
def images() -> list[tuple[int, NDArray[np.uint8]]]:
    return list(WALK.images())


def errors(trajectory: Trajectory) -> tuple[float, float]:
    """RMSE in metres and the worst angle in degrees, after the best similarity transform."""
    stamps_ns = WALK.stamps_ns()
    true = np.array([WALK.poses[stamps_ns.index(at)] for at, _ in trajectory])
    found = np.array([pose for _, pose in trajectory])
    a, b = found[:, :3, 3], true[:, :3, 3]
    centred_a, centred_b = a - a.mean(0), b - b.mean(0)
    u, values, v = np.linalg.svd(centred_b.T @ centred_a)
    mirror = np.diag([1, 1, np.linalg.det(u @ v)])
    rotation = u @ mirror @ v
    scale = np.trace(np.diag(values) @ mirror) / (centred_a**2).sum()
    off = scale * centred_a @ rotation.T - centred_b
    turns = np.einsum("nji,njk->nik", rotation @ found[:, :3, :3], true[:, :3, :3])
    angles = [float(np.linalg.norm(cv2.Rodrigues(it)[0])) for it in turns]
    return float(np.sqrt((off**2).sum(1).mean())), float(np.degrees(max(angles)))


def test_every_image_is_placed_where_the_camera_was(
    images: list[tuple[int, NDArray[np.uint8]]],
) -> None:
    found = odometry(iter(images), CAMERA)
    assert [at for at, _ in found] == WALK.stamps_ns(), "those before the start too"
    rmse_m, worst_deg = errors(found)
    print(f"RMSE {rmse_m:.4f} m, worst turn {worst_deg:.3f} deg")
    assert rmse_m < 0.02
    assert worst_deg < 2


def test_lost_images_do_not_lose_the_way(images: list[tuple[int, NDArray[np.uint8]]]) -> None:
    kept = [it for number, it in enumerate(images) if number % 10 not in (4, 5)]
    found = odometry(iter(kept), CAMERA)
    assert len(found) == len(kept)
    assert errors(found)[0] < 0.04


def test_after_a_dark_moment_the_rest_is_missing_rather_than_wrong(
    images: list[tuple[int, NDArray[np.uint8]]],
) -> None:
    dark = np.zeros((SIDE_PX, SIDE_PX), np.uint8)
    found = odometry(((at, dark if n >= 60 else it) for n, (at, it) in enumerate(images)), CAMERA)
    assert [at for at, _ in found] == WALK.stamps_ns()[:60]


@pytest.mark.parametrize("count", [0, 1, 20])
def test_a_camera_that_rests_gives_no_trajectory(
    images: list[tuple[int, NDArray[np.uint8]]], count: int
) -> None:
    with pytest.raises(EvaluationError, match="hardly moves"):
        odometry(((n * PERIOD_NS, images[0][1]) for n in range(count)), CAMERA)


def test_a_landmark_is_where_its_rays_meet() -> None:
    """Two cameras 1 m apart look straight ahead at a point 4 m away; a third adds nothing new."""
    landmarks, ids, there = Landmarks(), np.array([7]), np.array([0.3, -0.2, 4.0])
    for x in (0.0, 1.0, 2.0):
        pose = np.eye(4)
        pose[0, 3] = x
        assert landmarks.known(ids).all() == (x > 1)
        landmarks.see(ids, ((there - pose[:3, 3]) / 4.0)[None], pose)
    assert landmarks.points(ids)[0] == pytest.approx(there)


def test_a_landmark_seen_along_one_line_has_no_place() -> None:
    landmarks, ids = Landmarks(), np.array([0])
    for z in (0.0, 1.0, 2.0):
        pose = np.eye(4)
        pose[2, 3] = z
        landmarks.see(ids, np.array([[0.0, 0.0, 1.0]]), pose)
    assert not landmarks.known(ids).any()
