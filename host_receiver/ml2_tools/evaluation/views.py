"""What one image shows, and the poses that follow from two images or from landmarks."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.pose import Pose
from .landmarks import Floats, Landmarks
from .tracks import Pixels

LEAST_START_POINTS = 60
LEAST_POINTS = 15
_START_PARALLAX_RAD = np.radians(2.0)
# Of the tracks that both images have, so many must fit one motion.
_LEAST_FITTING = 0.7
_RANSAC_ROUNDS = 100
_NO_DISTORTION = np.zeros(4)


class View:
    """What an image shows: rays (x, y, 1) of tracks, and where its camera is."""

    def __init__(self, ids: NDArray[np.int64], rays: Floats, pose: Pose) -> None:
        self.ids, self.rays, self.pose = ids, rays, pose

    def common(self, other: View) -> tuple[Floats, Floats]:
        """Rays of the tracks that both have."""
        _, ours, theirs = np.intersect1d(self.ids, other.ids, return_indices=True)
        return self.rays[ours], other.rays[theirs]


def rays_of(pixels: Pixels, matrix: Floats) -> Floats:
    homogeneous = np.hstack([pixels.astype(np.float64), np.ones((len(pixels), 1))])
    rays: Floats = homogeneous @ np.linalg.inv(matrix).T
    return rays


def parallax_rad(one: View, other: View) -> float:
    """The median angle between rays to the same points."""
    ours, theirs = one.common(other)
    if not len(ours):
        return np.inf
    a, b = ours @ one.pose[:3, :3].T, theirs @ other.pose[:3, :3].T
    cosines = np.einsum("ij,ij->i", a, b) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    return float(np.median(np.arccos(cosines.clip(-1, 1))))


def relative_pose(one: View, other: View, focal_px: float) -> Pose | None:
    """Where the other camera is in the frame of the one, at distance 1; None if that is unclear."""
    ours, theirs = one.common(other)
    if len(ours) < LEAST_START_POINTS:
        return None
    essential, is_right = cv2.findEssentialMat(
        ours[:, :2], theirs[:, :2], np.eye(3), cv2.RANSAC, 0.9999, 1 / focal_px
    )
    if essential is None or essential.shape != (3, 3):
        return None
    count, rotation, translation, _ = cv2.recoverPose(
        essential, ours[:, :2], theirs[:, :2], np.eye(3), mask=is_right
    )
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation.T, -rotation.T @ translation.ravel()
    moved = View(other.ids, other.rays, pose)
    is_clear = count > _LEAST_FITTING * len(ours) and parallax_rad(one, moved) > _START_PARALLAX_RAD
    return pose if is_clear else None


def placed(
    view: View, landmarks: Landmarks, guess: Pose, most_off: float
) -> tuple[Pose, NDArray[np.bool_]]:
    """The pose that sees the landmarks where they are seen, and which tracks agree with it."""
    is_right = landmarks.known(view.ids)
    seen = np.flatnonzero(is_right)
    is_right = np.zeros(len(view.ids), bool)
    if len(seen) < LEAST_POINTS:
        return guess, is_right
    points, pixels = landmarks.points(view.ids[seen]), view.rays[seen, :2].copy()
    is_found, turn, shift, inliers = cv2.solvePnPRansac(
        points,
        pixels,
        np.eye(3),
        _NO_DISTORTION,
        *_inverse_vectors(guess),
        useExtrinsicGuess=True,
        iterationsCount=_RANSAC_ROUNDS,
        reprojectionError=most_off,
        confidence=0.999,
    )
    if not is_found or inliers is None:
        return guess, is_right
    good = inliers.ravel()
    turn, shift = cv2.solvePnPRefineLM(
        points[good], pixels[good], np.eye(3), _NO_DISTORTION, turn, shift
    )
    is_right[seen[good]] = True
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(turn)[0].T
    pose[:3, 3] = -pose[:3, :3] @ np.ravel(shift)
    return pose, is_right


def _inverse_vectors(pose: Pose) -> tuple[Floats, Floats]:
    rotation = pose[:3, :3].T
    vector = cv2.Rodrigues(rotation)[0]
    return vector.astype(np.float64), (-rotation @ pose[:3, 3:]).astype(np.float64)
