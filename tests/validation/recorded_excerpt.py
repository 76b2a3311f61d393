"""The recorded excerpt of EuRoC, replayed through ROS 2."""

from __future__ import annotations

import sys
from pathlib import Path

from processes import EXCERPT, ROOT, receive
from simulated_walk import record

CAMERA = "world_left"


def replay(folder: Path) -> Path:
    """A recording of what arrived; the ground truth is in its transforms."""
    folder.mkdir(parents=True)
    config = ROOT / "config" / "demo.yaml"
    received = receive(config, ["--replay", str(EXCERPT)], folder)
    record(received, folder / "bag", 0, sys.maxsize)
    return folder / "bag"
