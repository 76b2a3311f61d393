"""Stamps made over a link with delays, held against the grid on which the simulation measures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from capture_stamps import stamp_ns
from processes import receive
from proxy import Proxy
from simulated_truth import SimulatedTruth

GYRO = "gyro_left/imu"
# Readings are taken at multiples of this of CLOCK_BOOTTIME.
GRID_NS = 5_000_000
CONVERGED_NS = 2_000_000_000


@pytest.mark.parametrize("jitter_s", [0.0, 0.005])
def test_stamps_are_within_what_the_clock_claims(tmp_path: Path, jitter_s: float) -> None:
    config = tmp_path / "config.yaml"
    config.write_text("/ml2_receiver:\n  ros__parameters:\n    other_sensors: {enabled: true}\n")
    before = SimulatedTruth.now()
    link = (lambda address: Proxy(address, jitter_s=jitter_s)) if jitter_s else None
    received = receive(config, ["--duration", "6"], tmp_path, link)
    truth = SimulatedTruth.now()
    assert abs(truth.boottime_ns - before.boottime_ns) < 200_000, "this machine's clock was set"
    stamps = np.array([stamp_ns(it) for it in received.messages(GYRO)])
    errors_ns = off_the_grid(stamps[stamps > stamps[0] + CONVERGED_NS] + truth.boottime_ns)
    claimed_ns = int(received.snapshot["clock"]["uncertainty_ns"])
    p99_ns = float(np.percentile(np.abs(errors_ns), 99))
    print(f"jitter {jitter_s} s: p99 {p99_ns:.0f} ns, claimed {claimed_ns} ns")
    assert len(errors_ns) > 500
    assert np.mean(np.abs(errors_ns) <= claimed_ns) > 0.99
    assert p99_ns < 200_000


def off_the_grid(boottimes_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """How much later than the nearest instant of the grid."""
    return (boottimes_ns + GRID_NS // 2) % GRID_NS - GRID_NS // 2
