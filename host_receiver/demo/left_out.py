"""What the simulated headset says of images that it rendered while it streamed."""

from __future__ import annotations

import re
from pathlib import Path

_LINE = re.compile(r"^ml2sim: (.+) camera: (\d+) captures left out so far", re.MULTILINE)


def left_out(log: Path) -> str | None:
    """Returns how many captures each camera has left out so far; None if there are none.

    Args:
        log: the standard error of the headset.
    """
    cameras = dict(_LINE.findall(log.read_text(errors="replace")))
    if not cameras:
        return None
    counts = ", ".join(f"{camera} {count}" for camera, count in cameras.items())
    return f"captures left out while their images were drawn for the first time: {counts}"
