"""Each fault changes what its name says, and nothing else."""

from pathlib import Path

import numpy as np
import pytest

from faults import FAULTS, inject
from ml2_tools.evaluation.sequence import Sequence, read_sequence
from wall_walk import CAMERA, recording

COUNT = 40


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recording(tmp_path_factory.mktemp("walk") / "bag", COUNT)


def broken(fault: str, bag: Path, tmp_path: Path) -> Sequence:
    inject(FAULTS[fault], CAMERA, bag, tmp_path / "bag")
    return read_sequence(tmp_path / "bag", CAMERA)


@pytest.mark.parametrize("shift_ms", [5, 20])
def test_images_are_stamped_late_and_transforms_are_not(
    shift_ms: int, bag: Path, tmp_path: Path
) -> None:
    whole, it = read_sequence(bag, CAMERA), broken(f"stamps {shift_ms} ms late", bag, tmp_path)
    assert it.stamps_ns == [at + shift_ms * 1_000_000 for at in whole.stamps_ns]
    assert [at for at, _ in it.reference] == [at for at, _ in whole.reference]
    assert it.camera == whole.camera


def test_lost_images_are_missed(bag: Path, tmp_path: Path) -> None:
    it = broken("5 % of the images lost", bag, tmp_path)
    assert it.images_sent == COUNT
    assert COUNT - 8 < len(it.stamps_ns) < COUNT


def test_jpeg_compression_changes_pixels(bag: Path, tmp_path: Path) -> None:
    whole, it = read_sequence(bag, CAMERA), broken("JPEG of quality 50", bag, tmp_path)
    for (_, before), (_, after) in zip(whole.images(), it.images(), strict=True):
        difference = np.abs(before.astype(int) - after).mean()
        assert 0.5 < difference < 20


def test_a_wrong_lens_model_is_in_camera_info_and_metadata(bag: Path, tmp_path: Path) -> None:
    whole, it = read_sequence(bag, CAMERA), broken("wrong distortion model", bag, tmp_path)
    assert (whole.camera.lens.model, it.camera.lens.model) == ("equidistant", "plumb_bob")
    assert it.camera.lens.coefficients[:4] == whole.camera.lens.coefficients
