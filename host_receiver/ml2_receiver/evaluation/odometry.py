"""A small monocular visual odometry: places each image as it comes, fast enough for live images."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import EvaluationError
from ..export.pose import Pose
from ..products.camera import Camera
from ..products.rectification import rectify
from .estimator import Images, Trajectory
from .landmarks import Floats, Landmarks
from .tracks import Grey, Pixels, Tracks

_LARGEST_SIDE_PX = 1100
# Angles between rays at the start, and what the camera must have moved by before a new keyframe.
_START_PARALLAX_RAD = np.radians(2.0)
_KEY_PARALLAX_RAD = np.radians(1.0)
_LEAST_START_POINTS = 60
_LEAST_POINTS = 15
_LEAST_KEPT = 0.75
_MOST_OFF_PX = 1.5
_RANSAC_ROUNDS = 100


def odometry(images: Images, camera: Camera) -> Trajectory:
    """An estimator; neither closes loops nor adjusts bundles, so its error grows with the way.

    The unit of length is the distance between the two images that it starts from. When it loses
    its way, the images from there on are missing.
    """
    way = _Way(camera)
    for stamp_ns, image in images:
        way.take(stamp_ns, image)
    if not way.poses:
        raise EvaluationError(
            "odometry found no start: the camera hardly moves, or sees too little"
        )
    return sorted(way.poses.items())


class _Way:
    """Where the camera has been so far.

    Attributes:
        poses: of the optical frame, by stamp_ns.
    """

    def __init__(self, camera: Camera) -> None:
        size = max(camera.lens.width, camera.lens.height)
        self._scale = min(1.0, _LARGEST_SIDE_PX / size)
        self._camera = camera
        matrix = np.array(camera.matrix).reshape(3, 3)
        half = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])
        scaled = np.diag([self._scale, self._scale, 1]) @ half @ matrix
        self._matrix: Floats = np.linalg.inv(half) @ scaled
        self._mask = self._seen_by_lens()
        self.poses: dict[int, Pose] = {}
        self._tracks, self._landmarks = Tracks(), Landmarks()
        self._pose: Pose = np.eye(4)
        self._turn: Floats = np.eye(3)
        self._key = _View(np.zeros(0, np.int64), np.zeros((0, 3)), np.eye(4))
        self._waiting: list[tuple[int, _View]] = []

    def take(self, stamp_ns: int, image: Grey) -> None:
        """The next image."""
        self._tracks.follow(self._pinhole(image), self._expected())
        if not self.poses:
            self._begin(stamp_ns)
            return
        before = self._pose
        if not self._place():
            return
        self._turn = self._pose[:3, :3].T @ before[:3, :3]
        self.poses[stamp_ns] = self._pose
        if self._is_key():
            self._make_key()

    def _begin(self, stamp_ns: int) -> None:
        """Waits until some image before sees the same points from elsewhere."""
        if len(self._tracks.ids) < _LEAST_START_POINTS:
            self._waiting.clear()
            self._tracks.replenish(self._mask)
        now = self._view(np.eye(4))
        self._waiting.append((stamp_ns, now))
        first = self._waiting[0][1]
        pair = _relative(first, now, float(self._matrix[0, 0]))
        if pair is None:
            return
        self._pose = pair
        self._landmarks.see(first.ids, first.rays, first.pose)
        self._make_key()
        for at, view in self._waiting:
            self._pose = _placed(view, self._landmarks, self._pose, self._off())[0]
            self.poses[at] = self._pose
        self._waiting.clear()

    def _place(self) -> bool:
        """Whether enough landmarks say where the camera is now."""
        view = self._view(self._pose)
        pose, is_right = _placed(view, self._landmarks, self._pose, self._off())
        if int(is_right.sum()) < _LEAST_POINTS:
            return False
        self._pose = pose
        self._tracks.keep(is_right | ~self._landmarks.known(view.ids))
        return True

    def _is_key(self) -> bool:
        view = self._view(self._pose)
        kept = np.isin(self._key.ids, view.ids).mean()
        return bool(kept < _LEAST_KEPT) or _parallax_rad(self._key, view) > _KEY_PARALLAX_RAD

    def _make_key(self) -> None:
        view = self._view(self._pose)
        self._landmarks.see(view.ids, view.rays, view.pose)
        self._tracks.replenish(self._mask)
        new = np.setdiff1d(self._tracks.ids, view.ids)
        self._key = self._view(self._pose)
        is_new = np.isin(self._key.ids, new)
        self._landmarks.see(self._key.ids[is_new], self._key.rays[is_new], self._pose)

    def _view(self, pose: Pose) -> _View:
        return _View(self._tracks.ids.copy(), _rays(self._tracks.pixels, self._matrix), pose)

    def _expected(self) -> Pixels:
        """Where the corners will be when the camera goes on turning as it does."""
        rays = _rays(self._tracks.pixels, self._matrix) @ self._turn.T
        pixels = rays @ self._matrix.T
        return (pixels[:, :2] / np.maximum(pixels[:, 2:], 0.1)).astype(np.float32)

    def _off(self) -> float:
        """_MOST_OFF_PX as a length at depth 1."""
        return _MOST_OFF_PX / float(self._matrix[0, 0])

    def _pinhole(self, image: Grey) -> Grey:
        it = rectify(image, self._camera)
        if self._scale == 1:
            return it
        size = self._mask.shape[::-1]
        return cv2.resize(it, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)

    def _seen_by_lens(self) -> Grey:
        """Where rectified images show anything, without the edge of that."""
        lens = self._camera.lens
        white = rectify(np.full((lens.height, lens.width), 255, np.uint8), self._camera)
        size = round(lens.width * self._scale), round(lens.height * self._scale)
        mask = cv2.resize(white, size, interpolation=cv2.INTER_NEAREST)
        return cv2.erode(mask, np.ones((15, 15), np.uint8), borderValue=0).astype(np.uint8)


class _View:
    """What an image shows: rays (x, y, 1) of tracks, and where its camera is."""

    def __init__(self, ids: NDArray[np.int64], rays: Floats, pose: Pose) -> None:
        self.ids, self.rays, self.pose = ids, rays, pose

    def common(self, other: _View) -> tuple[Floats, Floats]:
        """Rays of the tracks that both have."""
        _, ours, theirs = np.intersect1d(self.ids, other.ids, return_indices=True)
        return self.rays[ours], other.rays[theirs]


def _rays(pixels: Pixels, matrix: Floats) -> Floats:
    homogeneous = np.hstack([pixels.astype(np.float64), np.ones((len(pixels), 1))])
    rays: Floats = homogeneous @ np.linalg.inv(matrix).T
    return rays


def _parallax_rad(one: _View, other: _View) -> float:
    """The median angle between rays to the same points."""
    ours, theirs = one.common(other)
    if not len(ours):
        return np.inf
    a, b = ours @ one.pose[:3, :3].T, theirs @ other.pose[:3, :3].T
    cosines = np.einsum("ij,ij->i", a, b) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    return float(np.median(np.arccos(cosines.clip(-1, 1))))


def _relative(one: _View, other: _View, focal_px: float) -> Pose | None:
    """Where the other camera is in the frame of the one, at distance 1; None if that is unclear."""
    ours, theirs = one.common(other)
    if len(ours) < _LEAST_START_POINTS:
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
    moved = _View(other.ids, other.rays, pose)
    is_clear = count > 0.7 * len(ours) and _parallax_rad(one, moved) > _START_PARALLAX_RAD
    return pose if is_clear else None


def _placed(
    view: _View, landmarks: Landmarks, guess: Pose, most_off: float
) -> tuple[Pose, NDArray[np.bool_]]:
    """The pose that sees the landmarks where they are seen, and which tracks agree with it."""
    is_right = landmarks.known(view.ids)
    seen = np.flatnonzero(is_right)
    is_right = np.zeros(len(view.ids), bool)
    if len(seen) < _LEAST_POINTS:
        return guess, is_right
    points, pixels = landmarks.points(view.ids[seen]), view.rays[seen, :2].copy()
    rotation, translation = _inverse_vectors(guess)
    is_found, rotation, translation, inliers = cv2.solvePnPRansac(
        points,
        pixels,
        np.eye(3),
        None,
        rotation,
        translation,
        useExtrinsicGuess=True,
        iterationsCount=_RANSAC_ROUNDS,
        reprojectionError=most_off,
        confidence=0.999,
    )
    if not is_found or inliers is None:
        return guess, is_right
    good = inliers.ravel()
    rotation, translation = cv2.solvePnPRefineLM(
        points[good], pixels[good], np.eye(3), None, rotation, translation
    )
    is_right[seen[good]] = True
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(rotation)[0].T
    pose[:3, 3] = -pose[:3, :3] @ translation.ravel()
    return pose, is_right


def _inverse_vectors(pose: Pose) -> tuple[Floats, Floats]:
    rotation = pose[:3, :3].T
    vector = cv2.Rodrigues(rotation)[0]
    return vector.astype(np.float64), (-rotation @ pose[:3, 3:]).astype(np.float64)
