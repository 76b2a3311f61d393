"""A constant shift between images and poses is found, whatever world and scale the estimate has."""

import pytest

from ml2_tools.evaluation.time_offset import time_offset_s
from trajectories import START_NS, moved, wandering


@pytest.mark.parametrize("shift_s", [0.0, 0.005, -0.02])
def test_a_shift_is_found_to_a_fraction_of_a_millisecond(shift_s: float) -> None:
    reference = wandering(rate_hz=90, duration_s=8)
    estimate = moved(wandering(shift_s=shift_s, duration_s=7), 0.3, (1, 2, 0.5))
    assert time_offset_s(reference, estimate) == pytest.approx(shift_s, abs=2e-5)


def test_nothing_is_told_of_stamps_that_do_not_overlap() -> None:
    later = [(at + 10**12, pose) for at, pose in wandering()]
    assert time_offset_s(wandering(), later) is None


def test_nothing_is_told_of_a_head_at_rest() -> None:
    _, pose = wandering()[0]
    resting = [(START_NS + number * 33_000_000, pose) for number in range(60)]
    assert time_offset_s(resting, wandering(duration_s=1.5)) is None
