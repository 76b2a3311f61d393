"""The simulated headset's reports of captures that it left out while it drew images."""

import re
from pathlib import Path

_LINE = re.compile(r"^ml2sim: (.+) camera: (\d+) captures left out so far", re.MULTILINE)


def left_out(log: Path) -> dict[str, int]:
    """Returns how many captures each kind of camera has left out so far.

    Args:
        log: the standard error of the headset.
    """
    found: list[tuple[str, str]] = _LINE.findall(log.read_text(errors="replace"))
    return {camera: int(count) for camera, count in found}


def words(counts: dict[str, int]) -> str | None:
    """Returns a line for the user; None if nothing was left out."""
    if not counts:
        return None
    cameras = ", ".join(f"{camera} {count}" for camera, count in counts.items())
    return f"captures left out while images were drawn for the first time: {cameras}"
