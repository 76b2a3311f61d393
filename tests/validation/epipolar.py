"""Measures how far matched points are from the epipolar lines of the true poses."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from matching import Matcher
from ml2_tools.evaluation.trajectory import Images
from ml2_tools.geometry.camera import Camera
from ml2_tools.geometry.pose import Pose
from ml2_tools.images.rectification import rectify

# From closer places, errors of the poses turn the lines.
_SHORTEST_M = 0.02

type Floats = NDArray[np.float64]


def epipolar_errors_px(
    images: Images, camera: Camera, poses: Mapping[int, Pose], matcher: Matcher
) -> Floats:
    """Matches points of each rectified image with those of the next one.

    Args:
        poses: the true pose of the optical frame at each image's stamp_ns.

    Returns:
        For each match, its distance from the epipolar lines, the mean of both images, in px of the
        rectified images. Pairs of images from nearly the same place have none.
    """
    from_pixels = np.linalg.inv(np.array(camera.matrix).reshape(3, 3))
    described = ((at, matcher.describe(rectify(image, camera))) for at, image in images)
    errors = [np.empty(0)]
    for (one_ns, one), (other_ns, other) in pairwise(described):
        source, target = (_rectified(poses[at], camera) for at in (one_ns, other_ns))
        between = np.linalg.inv(target) @ source
        if np.linalg.norm(between[:3, 3]) >= _SHORTEST_M:
            fundamental = from_pixels.T @ _essential(between) @ from_pixels
            errors.append(_distances_px(fundamental, *matcher.match(one, other)))
    return np.concatenate(errors)


def _rectified(pose: Pose, camera: Camera) -> Pose:
    """Returns the pose of the rectified image's frame."""
    turned = pose.copy()
    turned[:3, :3] = pose[:3, :3] @ np.array(camera.rotation).reshape(3, 3).T
    return turned


def _essential(between: Pose) -> Floats:
    """Returns E with other.T @ E @ one = 0, for rays of the same point in both cameras."""
    x, y, z = between[:3, 3]
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(cross @ between[:3, :3])


def _distances_px(fundamental: Floats, one: Floats, other: Floats) -> Floats:
    at_one, at_other = (np.column_stack([it, np.ones(len(it))]) for it in (one, other))
    in_other, in_one = at_one @ fundamental.T, at_other @ fundamental
    products = np.abs(np.sum(at_other * in_other, axis=1))
    norms = (np.linalg.norm(it[:, :2], axis=1) for it in (in_one, in_other))
    return np.asarray(np.mean([products / it for it in norms], axis=0))
