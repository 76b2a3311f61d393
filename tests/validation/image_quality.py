"""`make image-quality`: compares raw images with the JPEGs that the headset makes of them.

Records a walk of the simulated headset, raw and with noise. The library that ships encodes these
pixels, OpenCV decodes them. Writes build/bench/image_quality.json, anew after each quality.
"""

import json
import logging
import statistics
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from epipolar import epipolar_errors_px
from links import NOISY
from matching import MATCHERS
from ml2_tools.evaluation.comparison import compare
from ml2_tools.evaluation.sequence import Sequence, read_sequence
from ml2_tools.evaluation.structure_from_motion import structure_from_motion
from ml2_tools.evaluation.trajectory import Images, Trajectory
from ml2_tools.evaluation.tum import read_tum
from native_encoders import GREY_JPEG, encode
from processes import ROOT
from simulated_walk import stream
from walks import WALKS

_RESULTS = ROOT / "build" / "bench" / "image_quality.json"
_WALK = WALKS[1]
_QUALITIES = (90, 80, 60, 40)
# The mapping's random choices change its error, so one seed alone says little.
_SEEDS = (1, 2, 3, 4, 5)
# Points are matched between images that are this many apart.
_INTERVAL = 4


@dataclass(frozen=True)
class Recorded:
    """A walk's raw images and the true poses of the camera."""

    sequence: Sequence
    truth: Trajectory

    def images(self, quality: int | None) -> Images:
        """Yields the images, as JPEG keeps them unless `quality` is None."""
        for stamp_ns, pixels in self.sequence.images():
            yield stamp_ns, pixels if quality is None else _decoded(_encoded(pixels, quality))


def main() -> None:
    _RESULTS.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix="ml2_image_quality") as name:
        walked = stream(_WALK, Path(name) / "walk", NOISY)
        recorded = Recorded(read_sequence(walked.bag, _WALK.camera), read_tum(walked.truth))
        for figures in compared(recorded):
            _RESULTS.write_text(json.dumps(figures, indent=2) + "\n")
    print(_RESULTS.read_text())


def compared(recorded: Recorded) -> Iterator[dict[str, Any]]:
    """Yields all figures so far, after each quality."""
    images = len(recorded.sequence.stamps_ns)
    raw = _errors("raw", recorded, None)
    figures: dict[str, Any] = {"trajectory": _WALK.name, "images": images, "seeds": _SEEDS}
    figures |= {"raw": raw}
    for quality in _QUALITIES:
        name = f"jpeg{quality}"
        jpeg = _losses(recorded, quality) | _errors(name, recorded, quality)
        changes = {
            f"{key}_change_percent": (jpeg[key] / raw[key] - 1) * 100
            for key in (*(f"{it}_median_px" for it in MATCHERS), "sfm_rmse_mm")
        }
        figures |= {name: jpeg | changes}
        yield figures


def _errors(name: str, recorded: Recorded, quality: int | None) -> dict[str, Any]:
    """Returns the errors of matches and of trajectories against the true poses."""
    errors: dict[str, Any] = {}
    for kind, matcher in MATCHERS.items():
        some = islice(recorded.images(quality), 0, None, _INTERVAL)
        truth = dict(recorded.truth)
        errors_px = epipolar_errors_px(some, recorded.sequence.camera, truth, matcher)
        errors[f"{kind}_matches"] = len(errors_px)
        errors[f"{kind}_median_px"] = float(np.median(errors_px))
        logging.info(f"{name}, {kind}: {errors[f'{kind}_median_px']:.4f} px")
    rmse_mm = [_trajectory_error_mm(name, recorded, quality, seed) for seed in _SEEDS]
    return errors | {
        "sfm_rmse_mm": statistics.median(rmse_mm),
        "sfm_least_rmse_mm": min(rmse_mm),
        "sfm_most_rmse_mm": max(rmse_mm),
        "sfm_rmse_mm_by_seed": rmse_mm,
    }


def _trajectory_error_mm(name: str, recorded: Recorded, quality: int | None, seed: int) -> float:
    camera = recorded.sequence.camera
    estimate = structure_from_motion(recorded.images(quality), camera, seed)
    rmse_mm = compare(recorded.truth, estimate).ape_m["rmse"] * 1000
    logging.info(f"{name}, seed {seed}: {len(estimate)} images placed, {rmse_mm:.3f} mm rmse")
    return rmse_mm


def _losses(recorded: Recorded, quality: int) -> dict[str, Any]:
    """Returns the means of the size and of the signal-to-noise ratio, against the raw pixels."""
    sizes_kb, psnr_db = [], []
    for _, pixels in recorded.images(None):
        jpeg = _encoded(pixels, quality)
        sizes_kb.append(len(jpeg) / 1000)
        psnr_db.append(cv2.PSNR(_decoded(jpeg), pixels))
    return {"image_kb": statistics.mean(sizes_kb), "psnr_db": statistics.mean(psnr_db)}


def _encoded(pixels: NDArray[np.uint8], quality: int) -> bytes:
    return encode(GREY_JPEG, pixels, quality)


def _decoded(jpeg: bytes) -> NDArray[np.uint8]:
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert image is not None
    return image.astype(np.uint8, copy=False)


if __name__ == "__main__":
    logging.basicConfig(format="[%(asctime)s] %(message)s", datefmt="%H:%M:%S", level=logging.INFO)
    main()
