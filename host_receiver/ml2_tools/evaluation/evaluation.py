"""A camera's trajectory from a recording's images, compared with the poses that are there too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ml2_receiver.errors import EvaluationError

from .comparison import Comparison, compare
from .sequence import Sequence
from .time_offset import time_offset_s
from .trajectory import Images, Trajectory


@dataclass(frozen=True)
class Agreement:
    """Of an estimate with one reference.

    Attributes:
        max_dt_s: the longest time between the stamps of a matched pair.
        offset_s: what added to the images' stamps would make them agree best; None if nothing
            tells.
    """

    reference: Trajectory
    comparison: Comparison
    max_dt_s: float
    offset_s: float | None


@dataclass(frozen=True)
class Evaluation:
    """Of one camera of one recording by one estimator.

    Attributes:
        headset: agreement with the headset's own poses.
        truth: agreement with the true poses, where they are known; what the estimator adds to
            `pipeline`, that of the headset's own poses with them.
    """

    camera: str
    estimator: str
    sequence: Sequence
    estimate: Trajectory
    headset: Agreement
    truth: Agreement | None
    pipeline: Agreement | None


def evaluate(
    sequence: Sequence,
    camera: str,
    truth: Trajectory | None = None,
    watched: Callable[[Images, int], Images] = lambda images, _: images,
) -> Evaluation:
    """Estimates the camera's trajectory by structure from motion and compares it.

    Takes a minute or more.

    Args:
        truth: poses of the optical frame in a world of its own, at any stamps.
        watched: is given the images that the estimator reads, and their number.

    Raises:
        RecordingError: the recording is broken.
        EvaluationError: it gives no trajectory, or a needed library is missing.
    """
    try:
        from .structure_from_motion import structure_from_motion
    except ModuleNotFoundError as error:
        raise EvaluationError(
            f"structure from motion needs {error.name}: pip install './host_receiver[evaluate]'"
        ) from error
    images = watched(sequence.images(), len(sequence.stamps_ns))
    return judged(sequence, camera, "sfm", structure_from_motion(images, sequence.camera), truth)


def judged(
    sequence: Sequence, camera: str, estimator: str, found: Trajectory, truth: Trajectory | None
) -> Evaluation:
    """What `estimator` found, compared with all there is to compare it with.

    Raises:
        EvaluationError: it is no trajectory, or what is needed is missing.
    """
    if len(found) < 3:
        raise EvaluationError(f"{estimator} placed {len(found)} images, of 3 or more needed")
    return Evaluation(
        camera,
        estimator,
        sequence,
        found,
        agreement(sequence.reference, found),
        None if truth is None else agreement(truth, found),
        None if truth is None else agreement(truth, sequence.reference),
    )


def agreement(reference: Trajectory, estimate: Trajectory) -> Agreement:
    """Compares the two.

    Raises:
        EvaluationError: evo cannot.
    """
    return Agreement(
        reference,
        comparison := compare(reference, estimate),
        _longest_difference_s(reference, comparison),
        time_offset_s(reference, estimate),
    )


def _longest_difference_s(reference: Trajectory, comparison: Comparison) -> float:
    """To the nearest pose of the reference, which is the one that evo matches."""
    known_s = np.array([stamp_ns for stamp_ns, _ in reference]) / 1e9
    after = np.clip(np.searchsorted(known_s, comparison.stamps_s), 1, len(known_s) - 1)
    to_both = np.abs(known_s[np.stack([after - 1, after])] - comparison.stamps_s)
    return float(to_both.min(axis=0).max())


def summary(it: Evaluation) -> dict[str, Any]:
    """The figures of an evaluation; lengths in m, times in s."""
    stamps_ns = it.sequence.stamps_ns
    return {
        "recording": it.sequence.bag.name,
        "camera": it.camera,
        "estimator": it.estimator,
        "duration_s": (stamps_ns[-1] - stamps_ns[0]) / 1e9,
        "images_sent": it.sequence.images_sent,
        "images_received": len(stamps_ns),
        "images_placed": len(it.estimate),
        **figures_of(it.headset),
        "truth": None if it.truth is None else figures_of(it.truth),
        "headset_against_truth": None if it.pipeline is None else figures_of(it.pipeline),
    }


def figures_of(it: Agreement) -> dict[str, Any]:
    """Those of one agreement; lengths in m, times in s."""
    comparison = it.comparison
    return {
        "path_m": comparison.reference_path_m,
        "estimated_path_m": comparison.estimate_path_m,
        "matched_pairs": comparison.matched_pairs,
        "max_dt_s": it.max_dt_s,
        **{f"{name}_m": value for name, value in comparison.ape_m.items()},
        "rpe_m_per_m": comparison.rpe_m,
        "rpe_deg_per_m": comparison.rpe_deg,
        "time_offset_s": it.offset_s,
    }
