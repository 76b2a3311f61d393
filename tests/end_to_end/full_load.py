"""A session with all simulated sensors, and the true poses of that time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from processes import PREFIX, Received, receive
from simulated_truth import SimulatedTruth
from simulation import CAMERAS, image_topic, raw_config

# A busy machine drops many messages, so the session lasts until this many have arrived.
_LEAST = {f"{PREFIX}/{image_topic(camera)}": 100 for camera in CAMERAS}
_LEAST[f"{PREFIX}/gyro_left/imu"] = 1000
_LONGEST_S = 60


@dataclass(frozen=True)
class FullLoad:
    """The received messages, the true poses of that time, and the receiver's log."""

    received: Received
    truth: SimulatedTruth
    log: str


def full_load(folder: Path, **changes: dict[str, Any]) -> FullLoad:
    """Runs all sensors until there are 5 s of readings, and 100 images of each camera.

    Args:
        changes: changes of the demo's configuration, by section.
    """
    config = folder / "everything.yaml"
    config.write_text(raw_config(**changes))
    truth = SimulatedTruth.now()
    received = receive(config, ["--duration", f"{_LONGEST_S}"], folder, is_enough=_is_enough)
    assert not truth.clock_was_set()
    return FullLoad(received, truth, (folder / "receiver.log").read_text())


def _is_enough(snapshot: dict[str, Any]) -> bool:
    topics = snapshot["topics"]
    return all(topics[name]["count"] >= least for name, least in _LEAST.items())
