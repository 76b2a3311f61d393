"""A session with all simulated sensors, and the true poses of that time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from processes import Received, receive
from simulated_truth import SimulatedTruth
from simulation import demo_config


@dataclass(frozen=True)
class FullLoad:
    """The received messages, the true poses of that time, and the receiver's log."""

    received: Received
    truth: SimulatedTruth
    log: str


def full_load(layout: str, folder: Path) -> FullLoad:
    """Runs all sensors for 5 s with a layout of the transform tree, "flat" or "rig"."""
    config = folder / "everything.yaml"
    depth = {"confidence": True, "flags": True}
    config.write_text(demo_config(tf={"layout": layout}, depth_center=depth))
    truth = SimulatedTruth.now()
    received = receive(config, ["--duration", "5"], folder)
    assert not truth.clock_was_set()
    return FullLoad(received, truth, (folder / "receiver.log").read_text())
