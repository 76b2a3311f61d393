"""Checks that the transform tree has a camera's pose at each image's stamp."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..images.image_topic import camera_namespace
from .check import Check, verdict_on_share
from .survey import Stamps, Survey, TopicRecord
from .timing import IMAGES

# Head poses come every 17 ms. Over a longer gap than two of them, interpolation is wrong while the
# head turns.
_LONGEST_INTERVAL_NS = 40_000_000
_MOST_UNCOVERED = 0.01
_MOST_AT_THE_ENDS = 0.05
_DEEPEST = 64

type Edge = tuple[str, str]


def coverage(survey: Survey) -> Iterator[Check]:
    """Checks every image topic that has a camera_info; eye cameras have none, and no pose."""
    parents = {child: (parent, child) for parent, child in (*survey.static, *survey.transforms)}
    for name, images in survey.topics.items():
        camera = camera_namespace(name)
        if images.type in IMAGES and images.stamps and f"{camera}/camera_info" in survey.topics:
            for frame in images.frames:
                yield _check_frame(name, images, frame, survey, _chain(frame, parents))


def _chain(frame: str, parents: dict[str, Edge]) -> list[Edge]:
    """Returns the transforms from the frame up to the root, at most _DEEPEST (a loop)."""
    chain: list[Edge] = []
    while frame in parents and len(chain) < _DEEPEST:
        chain.append(parents[frame])
        frame = parents[frame][0]
    return chain


def _check_frame(
    name: str, images: TopicRecord, frame: str, survey: Survey, chain: list[Edge]
) -> Check:
    if not chain or len(chain) == _DEEPEST:
        reason = "the transforms form a loop" if chain else f"no transform has the child {frame}"
        return Check(name, "transforms", "wrong", reason)
    world, stamps_ns = chain[-1][0], np.unique(images.stamps_ns)
    is_exact = is_between = np.ones(len(stamps_ns), bool)
    is_inside = is_exact.copy()
    for edge in chain:
        if edge in survey.transforms:
            known_ns = np.unique(np.array(survey.transforms[edge], np.int64))
            is_exact = is_exact & np.isin(stamps_ns, known_ns)
            is_between = is_between & _between(stamps_ns, known_ns)
            is_inside &= (stamps_ns >= known_ns[0]) & (stamps_ns <= known_ns[-1])
    figures = {
        "exact": int(is_exact.sum()),
        "between": int((is_between & ~is_exact).sum()),
        "uncovered": int((is_inside & ~is_between).sum()),
        "before_or_after": int((~is_inside).sum()),
    }
    return _check_of_figures(name, f"{frame} in {world}", figures, len(stamps_ns))


def _between(stamps_ns: Stamps, known_ns: Stamps) -> NDArray[np.bool_]:
    """Returns True for each stamp with a transform at it, or close ones before and after it."""
    after = np.searchsorted(known_ns, stamps_ns).clip(1, max(1, len(known_ns) - 1))
    earlier_ns, later_ns = known_ns[after - 1], known_ns[after.clip(max=len(known_ns) - 1)]
    is_near = (later_ns - earlier_ns <= _LONGEST_INTERVAL_NS) & (earlier_ns <= stamps_ns)
    is_known: NDArray[np.bool_] = np.isin(stamps_ns, known_ns)
    is_known |= is_near & (stamps_ns <= later_ns)
    return is_known


def _check_of_figures(name: str, frames: str, figures: dict[str, int], total: int) -> Check:
    uncovered, ends = figures["uncovered"], figures["before_or_after"]
    verdict = verdict_on_share(uncovered, total, _MOST_UNCOVERED)
    if verdict == "ok" and ends > _MOST_AT_THE_ENDS * total:
        verdict = "wrong" if ends == total else "hint"
    found = f"{frames} at the stamp of {figures['exact']} of {total} images"
    for key, text in (
        ("between", "between two stamps of {}"),
        ("uncovered", "unknown at {}"),
        ("before_or_after", "before or after all transforms {}"),
    ):
        if figures[key]:
            found += ", " + text.format(figures[key])
    return Check(name, "transforms", verdict, found, figures)
