"""A session with all simulated sensors, and the true poses of that time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from counters import Snapshot, have_arrived
from left_out import left_out
from processes import Received, receive
from simulated_truth import SimulatedTruth
from simulation import CAMERAS, EXACT, image_topic, raw_config

# A busy machine drops many messages, so the session lasts until this many have arrived.
_LEAST = {image_topic(camera): 60 for camera in CAMERAS}
_LEAST |= {image_topic("world_left"): 100, image_topic("depth"): 30, "gyro_left/imu": 1000}
# The controller's buttons repeat after 4 s.
_LEAST["controller/joy"] = 300


@dataclass(frozen=True)
class FullLoad:
    """The received messages, the true poses of that time, and what the programs said.

    Attributes:
        log: the receiver's log.
        left_out: the captures that each kind of camera left out to draw its images.
    """

    received: Received
    truth: SimulatedTruth
    log: str
    left_out: dict[str, int]


def full_load(
    folder: Path,
    *options: str,
    until: Callable[[Snapshot], bool] = lambda _: True,
    **changes: dict[str, Any],
) -> FullLoad:
    """Runs all sensors until there are 5 s of readings, and images of each camera.

    Args:
        options: more of ml2-headset.
        until: what must be true of a snapshot, too.
        changes: changes of the demo's configuration, by section.
    """
    config = folder / "everything.yaml"
    config.write_text(raw_config(**changes))
    have_all = have_arrived(_LEAST, of_others=1)

    def is_enough(snapshot: Snapshot) -> bool:
        return have_all(snapshot) and until(snapshot)

    truth = SimulatedTruth.now()
    received = receive(config, [*EXACT, *options], folder, is_enough=is_enough)
    assert not truth.clock_was_set()
    log = (folder / "receiver.log").read_text()
    return FullLoad(received, truth, log, left_out(folder / "headset.log"))
