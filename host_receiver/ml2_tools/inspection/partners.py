"""Checks that each image has the camera_info and the metadata of its capture."""

from collections.abc import Iterator

import numpy as np

from ..images.image_topic import camera_namespace
from .check import Check, verdict_on_share
from .survey import Stamps, Survey, TopicRecord
from .timing import IMAGES

_PARTNERS = {"camera_info": "sensor_msgs/msg/CameraInfo", "metadata": "std_msgs/msg/String"}
# A lossy link may lose one message in a hundred.
_MOST_ALONE = 0.01


def partners(survey: Survey) -> Iterator[Check]:
    """Checks every image topic whose camera also has a camera_info or metadata topic."""
    for name, images in survey.topics.items():
        if images.type not in IMAGES:
            continue
        camera = camera_namespace(name)
        for partner, type in _PARTNERS.items():
            other = survey.topics.get(f"{camera}/{partner}")
            # Other programs have other texts or messages by that name.
            if other is not None and other.type == type and not _is_foreign(other):
                yield _pairs(name, images, partner, other)


def _is_foreign(other: TopicRecord) -> bool:
    return bool(other.foreign) and not other.understood


def _pairs(name: str, images: TopicRecord, partner: str, other: TopicRecord) -> Check:
    """Checks one pair of topics; messages outside the time span of the other topic do not count."""
    images_ns, others_ns = np.unique(images.stamps_ns), np.unique(other.stamps_ns)
    check = f"pairs with {partner}"
    if not len(images_ns) or not len(others_ns):
        is_one_missing = len(images_ns) != len(others_ns)
        counts = f"{len(images_ns)} images, {len(others_ns)} {partner}"
        return Check(name, check, "wrong" if is_one_missing else "hint", counts)
    alone, orphans = _without(images_ns, others_ns), _without(others_ns, images_ns)
    pairs = len(np.intersect1d(images_ns, others_ns))
    figures = {"pairs": pairs, "images_alone": alone, f"{partner}_alone": orphans}
    if difference := _difference(images, other):
        return Check(name, check, "wrong", difference, figures)
    if not alone and not orphans:
        return Check(name, check, "ok", f"{pairs} pairs", figures)
    found = f"{alone} images without {partner}, {orphans} {partner} without image"
    verdict = verdict_on_share(alone + orphans, pairs, _MOST_ALONE)
    return Check(name, check, verdict, found, figures)


def _without(some_ns: Stamps, others_ns: Stamps) -> int:
    """Returns how many stamps have no partner, although others are earlier and later."""
    alone_ns = np.setdiff1d(some_ns, others_ns, assume_unique=True)
    return int(((alone_ns > others_ns[0]) & (alone_ns < others_ns[-1])).sum())


def _difference(images: TopicRecord, other: TopicRecord) -> str:
    """Returns a sentence on the frame or size in which the topics differ, or "" if they agree."""
    for quantity, of_images, of_others in (
        ("frame", images.frames, other.frames),
        ("size", images.sizes, other.sizes),
    ):
        if of_images and of_others and set(of_images) != set(of_others):
            found = f"{_listed(of_images)} and {_listed(of_others)}"
            return f"expected the same {quantity} in both, found {found}"
    return ""


def _listed(values: object) -> str:
    return ", ".join(sorted(map(str, values)))[:200]  # type: ignore[call-overload]
