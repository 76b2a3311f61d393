"""Matches points of two images, in the ways of COLMAP, ORB-SLAM and OpenVINS."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

_FEATURES = 1500
# The largest distance of a match's descriptors, relative to the second best match.
_RATIO = 0.8
_CORNERS, _QUALITY, _LEAST_APART_PX = 1000, 0.01, 10
_WINDOW_PX, _LEVELS = (21, 21), 4
# A point that is tracked there and back is at most this far from its start.
_LARGEST_RETURN_PX = 0.5

type Grey = NDArray[np.uint8]
type Floats = NDArray[np.float64]
type Matches = tuple[Floats, Floats]


class Matcher(NamedTuple):
    """One way to match points.

    Attributes:
        describe: returns what `match` needs of an image.
        match: returns the pixels of the matches in one image and in the other, each n x 2.
    """

    describe: Callable[[Grey], Any]
    match: Callable[[Any, Any], Matches]


class _Features(NamedTuple):
    pixels: Floats
    descriptors: NDArray[Any]


def _features(detector: cv2.Feature2D, image: Grey) -> _Features:
    everywhere = np.empty(0, np.uint8)
    points, descriptors = detector.detectAndCompute(image, everywhere)
    return _Features(np.array([it.pt for it in points]).reshape(-1, 2), np.asarray(descriptors))


def _nearest(norm: int, one: _Features, other: _Features) -> Matches:
    """Returns the features that are each other's best match, clearly better than the second."""
    if min(len(one.pixels), len(other.pixels)) < 2:
        return np.empty((0, 2)), np.empty((0, 2))
    matcher = cv2.BFMatcher(norm)
    there, back = (
        {
            best.queryIdx: best.trainIdx
            for best, second in matcher.knnMatch(source.descriptors, target.descriptors, 2)
            if best.distance < _RATIO * second.distance
        }
        for source, target in ((one, other), (other, one))
    )
    pairs = [(here, at) for here, at in there.items() if back.get(at) == here]
    indices = np.array(pairs, np.intp).reshape(-1, 2)
    return one.pixels[indices[:, 0]], other.pixels[indices[:, 1]]


def _tracked(one: Grey, other: Grey) -> Matches:
    """Tracks corners by optical flow; returns those that it tracks back to their place."""
    corners = cv2.goodFeaturesToTrack(one, _CORNERS, _QUALITY, _LEAST_APART_PX)
    if corners is None:
        return np.empty((0, 2)), np.empty((0, 2))
    start = np.asarray(corners, np.float32).reshape(-1, 2)
    end, is_there = _flow(one, other, start)
    returned, is_back = _flow(other, one, end)
    is_good = is_there & is_back
    is_good &= np.linalg.norm(start - returned, axis=1) < _LARGEST_RETURN_PX
    return start[is_good].astype(np.float64), end[is_good].astype(np.float64)


def _flow(
    one: Grey, other: Grey, pixels: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    found, is_found, _ = cv2.calcOpticalFlowPyrLK(
        one, other, pixels, np.empty_like(pixels), winSize=_WINDOW_PX, maxLevel=_LEVELS
    )
    return np.asarray(found, np.float32), np.asarray(is_found).ravel() == 1


def _itself(image: Grey) -> Grey:
    return image


MATCHERS = {
    "sift": Matcher(partial(_features, cv2.SIFT.create(_FEATURES)), partial(_nearest, cv2.NORM_L2)),
    "orb": Matcher(
        partial(_features, cv2.ORB.create(_FEATURES)), partial(_nearest, cv2.NORM_HAMMING)
    ),
    "flow": Matcher(_itself, _tracked),
}
