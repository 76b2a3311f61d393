"""Calibrates 20 mounts that the simulated headset draws, with its noise; part of `make validate`.

Writes build/validate/imu_calibration.json: for each seed the errors, and whether each is within two
of the standard deviations that were stated with it. SEED= chooses the first seed.
"""

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from head_motion import HeadMotion
from ml2_tools.calibration.imu import Estimate, estimate_mount
from noisy_headset import Mount, NoisyHeadset, write_path

RESULTS = Path(__file__).resolve().parents[2] / "build" / "validate" / "imu_calibration.json"
_SEEDS, _DURATION_S, _SMOOTHING_S = 20, 60, 0.02
_UNIT = "imu_left"


def calibrated(
    seed: int, smoothing_s: float = 0.0, duration_s: int = _DURATION_S
) -> tuple[Mount, Estimate]:
    """Returns a drawn mount, and the one that a motion of that seed shows.

    Args:
        smoothing_s: the age of the mean pose that head tracking reports.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "motion.tum"
        write_path(path, HeadMotion(seed), duration_s)
        headset = NoisyHeadset(path, seed=seed, mounts=seed)
        motion = headset.motion(_UNIT, duration_s, smoothing_s)
    return headset.mount(_UNIT), estimate_mount(motion)


def result(seed: int, true: Mount, found: Estimate) -> dict[str, Any]:
    turned = (found.rotation * true.rotation.inv()).magnitude()
    moved_m = float(np.linalg.norm(found.translation_m - true.translation_m))
    late_s = abs(found.time_offset_s - true.late_s)
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


def smoothed_error_s(seed: int, duration_s: int = _DURATION_S) -> float:
    """Returns by how much the offset differs from what smoothed poses add to it."""
    true, found = calibrated(seed, _SMOOTHING_S, duration_s)
    return abs(found.time_offset_s - (true.late_s - _SMOOTHING_S))


def main() -> int:
    first = int(sys.argv[1])
    results = []
    for seed in range(first, first + _SEEDS):
        results.append(result(seed, *calibrated(seed)))
        print(json.dumps(results[-1]), flush=True)
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    stated = sum(it["is_within_two_sigma"] for it in results)
    worst = [max(it[key] for it in results) for key in list(results[0])[1:4]]
    smoothed_s = smoothed_error_s(first)
    print(f"worst {worst}; {stated} of {_SEEDS} within two sigma; wrote {RESULTS}")
    print(f"poses smoothed by {_SMOOTHING_S} s: offset wrong by {smoothed_s:.6f} s")
    is_right = worst[0] < 0.1 and worst[1] < 0.005 and max(worst[2], smoothed_s) < 2e-4
    return 0 if is_right and stated >= 18 else 1


if __name__ == "__main__":
    sys.exit(main())
