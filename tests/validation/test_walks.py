"""The walks are as long as the thesis's trajectories, and move like a head."""

from functools import cache

import numpy as np
import pytest

from euroc import Matrix
from walks import WALKS, Walk, drawn_walks

THESIS_S_M = [(13.5, 5.3), (10.9, 6.0), (22.8, 12.3), (16.0, 8.0)]
# The least distance to the walls; images from closer have too little texture.
NEAREST_M = 1.0


def mounting() -> Matrix:
    matrix = np.eye(4)
    matrix[:3, 3] = 0.06, 0.05, 0.02
    return matrix


@cache
def places(walk: Walk) -> Matrix:
    """Returns the poses of the camera at 30 images per second, on the walk of the right length."""
    walk = walk.scaled(mounting())
    times_s = np.arange(0, walk.duration_s + 1e-9, 1 / 30)
    return np.array([walk.head(at_s) @ mounting() for at_s in times_s])


@pytest.mark.parametrize(("walk", "thesis"), list(zip(WALKS, THESIS_S_M, strict=True)))
def test_a_walk_has_the_length_of_the_thesis_trajectory(
    walk: Walk, thesis: tuple[float, float]
) -> None:
    steps_m = np.linalg.norm(np.diff(places(walk)[:, :3, 3], axis=0), axis=1)
    assert (walk.duration_s, steps_m.sum()) == pytest.approx(thesis, abs=1e-3)
    assert steps_m.max() * 30 < 1.0, "m/s"


@pytest.mark.parametrize("walk", [*WALKS, *(it for seed in range(6) for it in drawn_walks(seed))])
def test_a_walk_turns_by_over_200_degrees_and_stays_in_the_room(walk: Walk) -> None:
    poses = places(walk)
    yaw_deg = np.degrees(np.unwrap(np.arctan2(poses[:, 1, 0], poses[:, 0, 0])))
    assert np.ptp(yaw_deg) > 200
    assert np.abs(poses[:, 0, 3]).max() < 3.5 - NEAREST_M
    assert np.abs(poses[:, 1, 3]).max() < 3.0 - NEAREST_M


def test_a_seed_always_draws_the_same_walks_and_another_one_others() -> None:
    assert drawn_walks(1) == drawn_walks(1)
    assert len({drawn_walks(1)[0], *drawn_walks(2), *drawn_walks(3)}) == 5


def test_the_closed_loop_is_closed() -> None:
    (walk,) = (it for it in WALKS if "closed" in it.name)
    np.testing.assert_allclose(walk.head(0), walk.head(walk.duration_s), atol=1e-9)


def test_a_walk_begins_and_ends_at_rest() -> None:
    for walk in WALKS:
        for at_s in (0.0, walk.duration_s):
            moved_m = walk.head(at_s + 0.01)[:3, 3] - walk.head(at_s - 0.01)[:3, 3]
            assert np.linalg.norm(moved_m) < 1e-3
