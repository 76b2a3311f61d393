"""Measures the growth of memory, threads and open files under full load.

Usage: soak.py DURATION, in seconds. Writes build/bench/soak.json for each process: the slope of
resident memory over the last three quarters of the time, in MB per hour, and memory, threads and
open files at a quarter of the time and at the end.
"""

import json
import sys
from typing import Any

from full_load import RESULTS
from load_run import Usage, load_run
from processes import draw_images
from simulation import raw_config


def main(duration_s: float) -> None:
    folder = RESULTS / "soak"
    folder.mkdir(parents=True, exist_ok=True)
    config = folder / "config.yaml"
    config.write_text(raw_config())
    draw_images(config, ())
    (loaded,) = load_run(config, folder, duration_s)
    results = {
        "duration_s": loaded.duration_s,
        "drops": loaded.drops,
        "processes": {role: _growth(usage) for role, usage in loaded.usage.items()},
    }
    (RESULTS / "soak.json").write_text(json.dumps(results, indent=2) + "\n")


def _growth(usage: Usage) -> dict[str, Any]:
    since = len(usage.times_s) // 4
    return {
        "memory_mb_per_hour": usage.memory_mb_per_hour,
        "rss_mb": [usage.rss_bytes[since] / 1e6, usage.rss_bytes[-1] / 1e6],
        "threads": [usage.threads[since], usage.threads[-1]],
        "files": [usage.files[since], usage.files[-1]],
    }


if __name__ == "__main__":
    main(float(sys.argv[1]))
