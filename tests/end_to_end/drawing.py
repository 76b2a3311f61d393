"""Tells when the simulated headset has rendered all its images, and so leaves out no captures.

With an empty cache it leaves captures out, whatever a test asks of rates
(ml2-sensors-aar/simulator/README.md).
"""

from __future__ import annotations

import hashlib
import json
import re
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

from configurations import only
from left_out import left_out
from ml2_receiver.configuration.config import load_config
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import CAMERA_KEYS
from waiting import LIMIT_S

_CACHE = Path(__file__).resolve().parents[2] / "build/native/frame_cache"
_INCOMPLETE = re.compile(r"^ml2sim: (\S+\.frames): \d+ of (\d+) frames", re.MULTILINE)
_NOT_KEPT = "cannot keep the frames"
_PAGE_BYTES = 4096
# The longest of these decides which images there are.
_LOOP = "loop_seconds="
_LOOP_S = 4.0
# The headset says every two seconds what it left out.
_SAID_S = 3.0
# A camera that is opened later than that after others draws in the run itself, which is repeated.
_OPENED_S = 1.0


def note(config: Path, options: Sequence[str]) -> Path | None:
    """Returns the file that exists once a run's images are drawn; None if it simulates none.

    Args:
        options: of ml2-headset.
    """
    if "--replay" in options:
        return None
    cameras = {
        stream: {key: values[key] for key in (*CAMERA_KEYS, "backend")}
        for stream, values in load_config(config).requests.items()
        if "format" in values
    }
    if not cameras:
        return None
    text = json.dumps([cameras, _lasting(options)], sort_keys=True)
    return _cache(options) / f"drawn-{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def _cache(options: Sequence[str]) -> Path:
    """Returns the folder of a run's frames."""
    named = [Path(it.removeprefix("cache=")) for it in options if it.startswith("cache=")]
    return [_CACHE, *named][-1]


def cameras_alone(config: Path) -> str:
    """Returns a configuration without sensors that only take time from drawing."""
    (node,) = yaml.safe_load(config.read_text()).values()
    given: dict[str, dict[str, Any]] = node["ros__parameters"]
    table = load_table().streams
    requests = load_config(config).requests
    cameras = {table[it].section for it, values in requests.items() if "format" in values}
    sections = {it: given.get(it, {}) | {"enabled": True} for it in sorted(cameras)}
    return only({"general": given.get("general", {}), **sections})


def forget(config: Path, options: Sequence[str]) -> None:
    """Has the images of a run drawn again before the next one: its cache has lost some."""
    if drawn := note(config, options):
        drawn.unlink(missing_ok=True)


def _lasting(options: Sequence[str]) -> list[str]:
    """Returns the options that decide what the images are."""
    return [
        word
        for option, value in pairwise(options)
        if option in ("--simulate", "--seed") and "fault." not in value and "@" not in value
        for word in (option, value)
    ]


def drawing_options(options: Sequence[str]) -> list[str]:
    """Returns the options of a run that is to draw, which await_drawn() ends."""
    return [*_lasting(options), "--duration", "3600"]


def passes(options: Sequence[str], most: int) -> int:
    """Returns how many headsets may be needed: one repeats a loop, but not the path of a file."""
    return most if any(it.startswith("trajectory=") for it in options) else 1


def await_drawn(log: Path, options: Sequence[str]) -> int | None:
    """Waits until a running headset has rendered all frames that it shows.

    Returns how many it has not, or None if disk or cache have no room for them, so that each
    headset renders its own.

    Args:
        log: its standard output and error.
    """
    loops_s = [float(it.split("=")[1]) for it in options if it.startswith(_LOOP)]
    quiet_s = max(loops_s, default=_LOOP_S) + _SAID_S
    last: Any = None
    cache = _cache(options)
    since_s = time.monotonic()
    while True:
        text = log.read_text(errors="replace")
        if _NOT_KEPT in text:
            return None
        try:
            files = _INCOMPLETE.findall(text)
            missing = sum(_missing(cache / name, int(count)) for name, count in files)
        except FileNotFoundError:
            return None
        now = (missing, left_out(log), ": running" in text)
        if now != last:
            last, since_s = now, time.monotonic()
        still_s = time.monotonic() - since_s
        if now[2] and still_s > (_OPENED_S if missing == 0 else quiet_s):
            return missing
        assert still_s < LIMIT_S, f"no stream was accepted: {text}"
        time.sleep(0.1)  # nothing tells when the last frame is rendered


def _missing(frames: Path, count: int) -> int:
    """Returns how many frames are not rendered; a file ends in one byte for each (frame_file.h)."""
    pages = -(-count // _PAGE_BYTES)
    with frames.open("rb") as file:
        file.seek(-pages * _PAGE_BYTES, 2)
        return file.read(count).count(0)
