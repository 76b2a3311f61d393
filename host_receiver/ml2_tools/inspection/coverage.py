"""Whether the transform tree says where a camera was at each of its images."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .check import Check, of_share
from .survey import Stamps, Survey, TopicRecord
from .timing import IMAGES

# Head poses come every 17 ms; over more than two of them interpolation misses a turning head.
_LONGEST_INTERVAL_NS = 40_000_000
_MOST_UNCOVERED = 0.01
_MOST_AT_THE_ENDS = 0.05
_DEEPEST = 64

type Edge = tuple[str, str]


def coverage(survey: Survey) -> Iterator[Check]:
    """Of every image topic whose headset also says how its lens is: eye cameras have no place."""
    parents = {child: (parent, child) for parent, child in (*survey.static, *survey.transforms)}
    for name, images in survey.topics.items():
        camera = name.removesuffix("/compressed").rpartition("/")[0]
        if images.type in IMAGES and images.stamps and f"{camera}/camera_info" in survey.topics:
            for frame in images.frames:
                yield _covered(name, images, frame, survey, _way(frame, parents))


def _way(frame: str, parents: dict[str, Edge]) -> list[Edge]:
    """The transforms from the frame up to the last that is known; a ring has no end."""
    way: list[Edge] = []
    while frame in parents and len(way) < _DEEPEST:
        way.append(parents[frame])
        frame = parents[frame][0]
    return way


def _covered(name: str, images: TopicRecord, frame: str, survey: Survey, way: list[Edge]) -> Check:
    if not way or len(way) == _DEEPEST:
        reason = "the transforms are a ring" if way else f"no transform says where {frame} is"
        return Check(name, "transforms", "wrong", reason)
    world, stamps_ns = way[-1][0], np.unique(images.stamps_ns)
    is_exact = is_between = np.ones(len(stamps_ns), bool)
    is_inside = is_exact.copy()
    for edge in way:
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
    return _judged(name, f"{frame} in {world}", figures, len(stamps_ns))


def _between(stamps_ns: Stamps, known_ns: Stamps) -> NDArray[np.bool_]:
    """Whether there is a transform at the stamp, or one before and one after, near enough."""
    after = np.searchsorted(known_ns, stamps_ns).clip(1, max(1, len(known_ns) - 1))
    earlier_ns, later_ns = known_ns[after - 1], known_ns[after.clip(max=len(known_ns) - 1)]
    is_near = (later_ns - earlier_ns <= _LONGEST_INTERVAL_NS) & (earlier_ns <= stamps_ns)
    is_known: NDArray[np.bool_] = np.isin(stamps_ns, known_ns)
    is_known |= is_near & (stamps_ns <= later_ns)
    return is_known


def _judged(name: str, what: str, figures: dict[str, int], total: int) -> Check:
    uncovered, ends = figures["uncovered"], figures["before_or_after"]
    verdict = of_share(uncovered, total, _MOST_UNCOVERED)
    if verdict == "ok" and ends > _MOST_AT_THE_ENDS * total:
        verdict = "wrong" if ends == total else "hint"
    found = f"{what} at the stamp of {figures['exact']} of {total} images"
    for key, text in (
        ("between", "between two stamps of {}"),
        ("uncovered", "unknown at {}"),
        ("before_or_after", "before or after all transforms {}"),
    ):
        if figures[key]:
            found += ", " + text.format(figures[key])
    return Check(name, "transforms", verdict, found, figures)
