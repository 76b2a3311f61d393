"""Structure from motion does not keep an image at a place that other images contradict."""

from pathlib import Path
from typing import Any

import numpy as np
import pycolmap
import pytest
from numpy.typing import NDArray

from ml2_tools.evaluation import structure_from_motion as sfm
from ml2_tools.evaluation.comparison import compare
from ml2_tools.evaluation.trajectory import Trajectory
from ml2_tools.geometry.camera import Camera
from ml2_tools.geometry.lens import Lens
from wall_walk import EQUIDISTANT, MATRIX, SIZE, images, trajectory

COUNT = 40
# Every fourth image is a key image.
KEY = 20
(_FX, _, _CX), (_, _FY, _CY), _ = MATRIX.tolist()
_LENS = Lens(*SIZE, fx=_FX, fy=_FY, cx=_CX, cy=_CY, model="equidistant", coefficients=EQUIDISTANT)
CAMERA = Camera(_LENS, tuple(np.eye(3).ravel()), tuple(MATRIX.ravel()))


@pytest.fixture(scope="module")
def walk() -> list[tuple[int, NDArray[np.uint8]]]:
    return list(images(COUNT))


def numbers_of(estimate: Trajectory) -> list[int]:
    stamps_ns = [stamp_ns for stamp_ns, _ in trajectory(COUNT)]
    return [stamps_ns.index(stamp_ns) for stamp_ns, _ in estimate]


def test_images_that_do_not_show_what_their_neighbours_see_are_not_placed(
    walk: list[tuple[int, NDArray[np.uint8]]],
) -> None:
    noise = np.random.default_rng(1).integers(0, 256, walk[0][1].shape, np.uint8)
    elsewhere, upside_down = walk[0][1], walk[22][1][::-1].copy()
    wrong = {14: noise, 22: upside_down, 30: elsewhere, 34: np.zeros_like(noise)}
    shown = [(at, wrong.get(number, pixels)) for number, (at, pixels) in enumerate(walk)]
    estimate = sfm.structure_from_motion(shown, CAMERA)
    assert numbers_of(estimate) == [it for it in range(COUNT) if it not in wrong]
    assert compare(trajectory(COUNT), estimate).ape_m["max"] < 0.01


def test_a_key_image_at_a_wrong_place_is_placed_anew(
    walk: list[tuple[int, NDArray[np.uint8]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    mapped = sfm._model

    def misplaced(folder: Path, *rest: Any) -> pycolmap.Reconstruction:
        model = mapped(folder, *rest)
        frame: Any = model.find_image_with_name(sfm._name(walk[KEY][0])).frame
        pose = frame.rig_from_world
        away = pose.translation + np.array([5, 0, 0])
        frame.rig_from_world = pycolmap.Rigid3d(pose.rotation, away)
        return model

    monkeypatch.setattr(sfm, "_model", misplaced)
    estimate = sfm.structure_from_motion(walk, CAMERA)
    assert numbers_of(estimate) == list(range(COUNT))
    assert compare(trajectory(COUNT), estimate).ape_m["max"] < 0.01
