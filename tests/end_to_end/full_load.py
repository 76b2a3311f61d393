"""A session of every simulated sensor, and what is true of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from processes import Received, receive
from simulated_truth import SimulatedTruth
from simulation import demo_config


@dataclass(frozen=True)
class FullLoad:
    """What arrived, the truth of that time, and the receiver's log."""

    received: Received
    truth: SimulatedTruth
    log: str


def full_load(layout: str, folder: Path) -> FullLoad:
    """Five seconds with this layout of the transform tree."""
    config = folder / "everything.yaml"
    depth = {"confidence": True, "flags": True}
    config.write_text(demo_config(tf={"layout": layout}, depth_center=depth))
    truth = SimulatedTruth.now()
    received = receive(config, ["--duration", "5"], folder)
    assert not truth.clock_was_set()
    return FullLoad(received, truth, (folder / "receiver.log").read_text())
