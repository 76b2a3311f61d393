"""Trajectories compared by evo, run as programs, and the shift between their times."""

import math
import sys

import numpy as np
import pytest

from ml2_tools.errors import EvaluationError
from ml2_tools.evaluation.comparison import STATISTICS, compare
from ml2_tools.evaluation.evaluation import agreement
from ml2_tools.evaluation.time_offset import time_offset_s
from trajectories import START_NS, moved, wandering

pytestmark = pytest.mark.processes


def test_another_world_and_scale_are_no_error() -> None:
    result = compare(wandering(rate_hz=90), moved(wandering(), 0.2, (1, -2, 0.5)))
    assert result.ape_m["max"] < 1e-5
    assert result.matched_pairs == len(wandering())
    assert result.estimate_path_m == pytest.approx(result.reference_path_m, abs=1e-4)
    assert np.cbrt(np.linalg.det(result.alignment[:3, :3])) == pytest.approx(5, abs=1e-3)


def test_errors_have_the_statistics_of_the_noise_that_was_put_in() -> None:
    noise_m = np.random.default_rng(1).normal(0, 0.03, (len(wandering()), 3))
    noisy = [(at, pose.copy()) for at, pose in wandering()]
    for (_, pose), error in zip(noisy, noise_m, strict=True):
        pose[:3, 3] += error
    result = compare(wandering(rate_hz=90), noisy)
    assert result.ape_m["rmse"] == pytest.approx(0.03 * math.sqrt(3), rel=0.1)
    assert set(result.ape_m) == set(STATISTICS)
    assert result.ape_m["min"] < result.ape_m["median"] < result.ape_m["max"]
    assert len(result.errors_m) == len(result.stamps_s) == len(noisy)
    assert result.rpe_m["rmse"] == pytest.approx(0.03 * math.sqrt(6), rel=0.2)


def test_stamps_are_matched_within_10_ms_and_no_further() -> None:
    half = len(wandering()) // 2
    estimate = [(at + 4_000_000, pose) for at, pose in wandering()[:half]]
    estimate += [(at + 14_000_000, pose) for at, pose in wandering()[half:]]
    found = agreement(wandering(), estimate)
    assert found.comparison.matched_pairs == half
    assert found.max_dt_s == pytest.approx(0.004, abs=1e-6)


def test_what_evo_cannot_compare_is_told() -> None:
    later = [(at + 10**12, pose) for at, pose in wandering()]
    with pytest.raises(EvaluationError, match="evo_ape cannot compare"):
        compare(wandering(), later)


def test_without_evo_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/dev/null/nowhere/python3")
    monkeypatch.setenv("PATH", "/dev/null/nowhere")
    with pytest.raises(EvaluationError, match=r"pip install '\./host_receiver\[evaluate\]'"):
        compare(wandering(), wandering())


def test_evo_is_never_imported() -> None:
    assert not [name for name in sys.modules if name.partition(".")[0] == "evo"]


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
