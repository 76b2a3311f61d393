"""Calibrates 20 drawn mounts from noisy motions of a minute; part of `make validate`.

Writes build/validate/imu_calibration.json: for each seed the errors, and whether each is within two
of the standard deviations that were stated with it.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from head_motion import HeadMotion
from ml2_tools.calibration.imu import estimate_mount

RESULTS = Path(__file__).resolve().parents[2] / "build" / "validate" / "imu_calibration.json"
_SEEDS, _DURATION_S = 20, 60.0


def result(seed: int) -> dict[str, Any]:
    motion = HeadMotion(seed)
    true, found = motion.mount, estimate_mount(motion.observed(_DURATION_S))
    turned = (found.rotation * true.rotation.inv()).magnitude()
    moved_m = float(np.linalg.norm(found.translation_m - true.translation_m))
    late_s = abs(found.time_offset_s - true.time_offset_s)
    is_stated = (
        turned <= 2 * np.linalg.norm(found.rotation_sigma_rad)
        and moved_m <= 2 * np.linalg.norm(found.translation_sigma_m)
        and late_s <= 2 * found.time_offset_sigma_s
    )
    return {
        "seed": seed,
        "rotation_error_deg": float(np.degrees(turned)),
        "translation_error_m": moved_m,
        "time_offset_error_s": late_s,
        "is_within_two_sigma": bool(is_stated),
    }


def main() -> int:
    results = []
    for seed in range(1, _SEEDS + 1):
        results.append(result(seed))
        print(json.dumps(results[-1]), flush=True)
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    stated = sum(it["is_within_two_sigma"] for it in results)
    worst = [max(it[key] for it in results) for key in list(results[0])[1:4]]
    print(f"worst {worst}; {stated} of {_SEEDS} within two sigma; wrote {RESULTS}")
    return 0 if worst[0] < 0.1 and worst[1] < 0.005 and worst[2] < 2e-4 and stated >= 18 else 1


if __name__ == "__main__":
    sys.exit(main())
