"""Measures every sensor at once, with raw images and a raw subscriber.

Usage: full_load.py DURATION, in seconds. Writes to build/bench:

full_load.json           in plaintext
full_load_tls.json       with TLS, after pairing
full_load_recorded.json  in plaintext, with a recording
four_headsets.json       four headsets with one camera and all small streams each, for a quarter of
                         the time

CPU is in percent of one processor. The headsets loop their frames. latency_ms is separate for the
first seconds ("start") and all later ones ("steady").
"""

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from configurations import only
from load_run import Loaded, load_run
from processes import ROOT, draw_images, paired
from simulation import STILL, raw_config

RESULTS = ROOT / "build" / "bench"
NAMES = ("robot1", "robot2", "robot3", "robot4")
ONE_CAMERA = only(
    """
    world_left: {enabled: true},
    other_sensors: {enabled: true},
    head_pose: {enabled: true},
    """
)


def main(duration_s: float) -> None:
    with tempfile.TemporaryDirectory(prefix="ml2_load") as name:
        folder = Path(name)
        logs = RESULTS / "full_load"
        raw = folder / "raw.yaml"
        raw.write_text(raw_config())
        draw_images(raw, ())
        (loaded,) = load_run(raw, logs, duration_s)
        _write("full_load", _summary(loaded))
        (loaded,) = load_run(raw, logs, duration_s, security=paired(folder))
        _write("full_load_tls", _summary(loaded) | {"tls": True})
        (loaded,) = load_run(raw, logs, duration_s, record=folder / "recording")
        recorded_bytes = sum(file.stat().st_size for file in (folder / "recording").iterdir())
        rate = recorded_bytes / 1e6 / loaded.duration_s
        _write("full_load_recorded", _summary(loaded) | {"recorded_mb_per_s": rate})
        config = folder / "one_camera.yaml"
        config.write_text(ONE_CAMERA)
        draw_images(config, STILL)
        each = load_run(config, logs, duration_s / 4, NAMES, headset_options=STILL)
        results = {name: _summary(it) for name, it in zip(NAMES, each, strict=True)}
        _write("four_headsets", results)


def _summary(loaded: Loaded) -> dict[str, Any]:
    return {
        "drops": loaded.drops,
        "drops_after_start": loaded.drops_after_start,
        "latency_ms": loaded.latency_ms,
        "cpu_percent": {role: usage.cpu_percent for role, usage in loaded.usage.items()},
        "tls": False,
        "duration_s": loaded.duration_s,
    }


def _write(name: str, results: dict[str, Any]) -> None:
    RESULTS.mkdir(parents=True, exist_ok=True)
    (RESULTS / f"{name}.json").write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main(float(sys.argv[1]))
