"""Compares a camera's trajectory, estimated from a recording's images, with the recorded poses."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import EvaluationError
from .comparison import Comparison, compare
from .sequence import Sequence
from .time_offset import time_offset_s
from .trajectory import Images, Progress, Trajectory, untold

_OWN = "sfm"


@dataclass(frozen=True)
class Agreement:
    """The agreement of an estimate with one reference.

    Attributes:
        max_dt_s: the longest time between the stamps of a matched pair.
        offset_s: the time to add to the images' stamps for the best agreement; None if it cannot
            be computed.
    """

    reference: Trajectory
    comparison: Comparison
    max_dt_s: float
    offset_s: float | None


@dataclass(frozen=True)
class Evaluation:
    """The result for one camera of one recording and one estimator.

    Attributes:
        headset: agreement of the estimate with the headset's own poses.
        truth: agreement of the estimate with the true poses, if they are known.
        pipeline: agreement of the headset's own poses with the true poses, if they are known. The
            estimator causes the difference between `truth` and `pipeline`.
    """

    camera: str
    estimator: str
    sequence: Sequence
    estimate: Trajectory
    headset: Agreement
    truth: Agreement | None
    pipeline: Agreement | None

    @property
    def images_rejected(self) -> int | None:
        """The number of images that structure from motion could not place.

        None for other estimators, whose poses are at stamps of their own.
        """
        is_own = self.estimator == _OWN
        return len(self.sequence.stamps_ns) - len(self.estimate) if is_own else None


def evaluate(
    sequence: Sequence,
    camera: str,
    truth: Trajectory | None = None,
    progress: Progress = untold,
) -> Evaluation:
    """Estimates the camera's trajectory by structure from motion and compares it.

    Takes a minute or more.

    Args:
        truth: true poses of the optical frame, in any world and at any stamps.
        progress: is told of each step.

    Raises:
        RecordingError: the recording is broken.
        EvaluationError: the images give no trajectory, or a needed library is missing.
    """
    try:
        from .structure_from_motion import structure_from_motion
    except ModuleNotFoundError as error:
        raise EvaluationError(
            f"structure from motion needs {error.name}: pip install './host_receiver[evaluate]'"
        ) from error
    images = _read(sequence, progress)
    estimate = structure_from_motion(images, sequence.camera, progress=progress)
    return evaluate_estimate(sequence, camera, _OWN, estimate, truth)


def _read(sequence: Sequence, progress: Progress) -> Images:
    for done, image in enumerate(sequence.images()):
        progress("reading images", done, len(sequence.stamps_ns))
        yield image


def evaluate_estimate(
    sequence: Sequence, camera: str, estimator: str, estimate: Trajectory, truth: Trajectory | None
) -> Evaluation:
    """Compares an estimated trajectory with the headset's poses and, if known, the true poses.

    Raises:
        EvaluationError: the estimate has too few poses, or evo is missing or fails.
    """
    if len(estimate) < 3:
        raise EvaluationError(
            f"expected 3 or more images placed by {estimator}, found {len(estimate)}"
        )
    return Evaluation(
        camera,
        estimator,
        sequence,
        estimate,
        agreement(sequence.reference, estimate),
        None if truth is None else agreement(truth, estimate),
        None if truth is None else agreement(truth, sequence.reference),
    )


def agreement(reference: Trajectory, estimate: Trajectory) -> Agreement:
    """Compares an estimate with a reference.

    Raises:
        EvaluationError: evo is missing or fails.
    """
    return Agreement(
        reference,
        comparison := compare(reference, estimate),
        _longest_difference_s(reference, comparison),
        time_offset_s(reference, estimate),
    )


def _longest_difference_s(reference: Trajectory, comparison: Comparison) -> float:
    """Returns the longest time from a matched stamp to the nearest pose of the reference.

    evo matches the nearest pose.
    """
    known_s = np.array([stamp_ns for stamp_ns, _ in reference]) / 1e9
    after = np.clip(np.searchsorted(known_s, comparison.stamps_s), 1, len(known_s) - 1)
    to_both = np.abs(known_s[np.stack([after - 1, after])] - comparison.stamps_s)
    return float(to_both.min(axis=0).max())


def summary(evaluation: Evaluation) -> dict[str, Any]:
    """Returns the figures of an evaluation; lengths in m, times in s."""
    truth, pipeline = evaluation.truth, evaluation.pipeline
    stamps_ns = evaluation.sequence.stamps_ns
    return {
        "recording": evaluation.sequence.bag.name,
        "camera": evaluation.camera,
        "estimator": evaluation.estimator,
        "duration_s": (stamps_ns[-1] - stamps_ns[0]) / 1e9,
        "images_sent": evaluation.sequence.images_sent,
        "images_received": len(stamps_ns),
        "images_placed": len(evaluation.estimate),
        "images_rejected": evaluation.images_rejected,
        **figures_of(evaluation.headset),
        "truth": None if truth is None else figures_of(truth),
        "headset_against_truth": None if pipeline is None else figures_of(pipeline),
    }


def figures_of(one: Agreement) -> dict[str, Any]:
    """Returns the figures of one agreement; lengths in m, times in s."""
    comparison = one.comparison
    return {
        "path_m": comparison.reference_path_m,
        "estimated_path_m": comparison.estimate_path_m,
        "matched_pairs": comparison.matched_pairs,
        "max_dt_s": one.max_dt_s,
        **{f"{name}_m": value for name, value in comparison.ape_m.items()},
        "rpe_m_per_m": comparison.rpe_m,
        "rpe_deg_per_m": comparison.rpe_deg,
        "time_offset_s": one.offset_s,
    }
