"""When the simulated headset has drawn all its images, so that it leaves no captures out to draw.

With an empty cache it leaves captures out, whatever a test asks of rates
(ml2-sensors-aar/simulator/README.md).
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from left_out import left_out
from ml2_receiver.configuration.config import load_config
from ml2_receiver.table.stream_table import CAMERA_KEYS
from waiting import LIMIT_S

_CACHE = Path(__file__).resolve().parents[2] / "build/native/frame_cache"
# The longest of these decides which images there are.
_LOOP = "loop_seconds="
_LOOP_S = 4.0
# The headset says once a second what it left out; on a busy machine an image may take as long.
_SAID_S = 3.0


def note(config: Path, options: Sequence[str]) -> Path | None:
    """Returns the file that exists once the images of a run are drawn; None if none are simulated.

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
    text = json.dumps([cameras, _lasting(options)], sort_keys=True)
    return _CACHE / f"drawn-{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def _lasting(options: Sequence[str]) -> list[str]:
    """Returns the options that decide what the images are."""
    pairs = zip(options[::2], options[1::2], strict=True)
    return [
        word
        for option, value in pairs
        if option != "--duration" and "fault." not in value and "@" not in value
        for word in (option, value)
    ]


def drawing_options(options: Sequence[str]) -> list[str]:
    """Returns the options of a run that is to draw, which await_drawn() ends."""
    return [*_lasting(options), "--duration", f"{LIMIT_S}"]


def await_drawn(log: Path, options: Sequence[str]) -> None:
    """Waits until a running headset has shown all its images without leaving captures out.

    Args:
        log: its standard output and error.
    """
    loops_s = [float(it.split("=")[1]) for it in options if it.startswith(_LOOP)]
    quiet_s = max(loops_s, default=_LOOP_S) + _SAID_S
    end_s = time.monotonic() + LIMIT_S
    last: Any = None
    since_s = time.monotonic()
    while time.monotonic() < end_s:
        now = (left_out(log), ": accepted" in log.read_text(errors="replace"))
        if now != last:
            last, since_s = now, time.monotonic()
        if now[1] and time.monotonic() - since_s > quiet_s:
            return
        time.sleep(0.1)  # the headset says nothing when it has drawn all
