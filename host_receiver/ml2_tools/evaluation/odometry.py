"""A small monocular visual odometry: places each image as it comes, fast enough for live images."""

from __future__ import annotations

import cv2
import numpy as np

from ml2_receiver.errors import EvaluationError

from ..geometry.camera import Camera
from ..geometry.pose import Pose
from ..images.rectification import rectify
from .estimator import Images, Trajectory
from .landmarks import Floats, Landmarks
from .tracks import Grey, Pixels, Tracks
from .views import (
    LEAST_POINTS,
    LEAST_START_POINTS,
    View,
    parallax_rad,
    placed,
    rays_of,
    relative_pose,
)

# Larger images are made smaller, so that they are placed as fast as they come.
_LARGEST_SIDE_PX = 1024
# A keyframe is made when rays to the same points have turned so far, or fewer are left of them.
_KEY_PARALLAX_RAD = np.radians(1.0)
_LEAST_KEPT = 0.75
_MOST_OFF_PX = 1.5
_ROUGH = 4
_EDGE_PX = 15


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
        self._key = View(np.zeros(0, np.int64), np.zeros((0, 3)), np.eye(4))
        self._waiting: list[tuple[int, View]] = []

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
        if len(self._tracks.ids) < LEAST_START_POINTS:
            self._waiting.clear()
            self._tracks.replenish(self._mask)
        now = self._view(np.eye(4))
        self._waiting.append((stamp_ns, now))
        first = self._waiting[0][1]
        pair = relative_pose(first, now, float(self._matrix[0, 0]))
        if pair is None:
            return
        self._pose = pair
        self._landmarks.see(first.ids, first.rays, first.pose)
        self._make_key()
        for at, view in self._waiting:
            self._pose = placed(view, self._landmarks, self._pose, self._off())[0]
            self.poses[at] = self._pose
        self._waiting.clear()

    def _place(self) -> bool:
        """Whether enough landmarks say where the camera is now."""
        view = self._view(self._pose)
        pose, is_right = placed(view, self._landmarks, self._pose, self._off())
        if int(is_right.sum()) < LEAST_POINTS:  # rather a rough pose than none
            pose, is_right = placed(view, self._landmarks, self._pose, _ROUGH * self._off())
        if int(is_right.sum()) < LEAST_POINTS:
            return False
        self._pose = pose
        self._tracks.keep(is_right | ~self._landmarks.known(view.ids))
        return True

    def _is_key(self) -> bool:
        view = self._view(self._pose)
        kept = np.isin(self._key.ids, view.ids).mean()
        return bool(kept < _LEAST_KEPT) or parallax_rad(self._key, view) > _KEY_PARALLAX_RAD

    def _make_key(self) -> None:
        view = self._view(self._pose)
        self._landmarks.see(view.ids, view.rays, view.pose)
        self._tracks.replenish(self._mask)
        new = np.setdiff1d(self._tracks.ids, view.ids)
        self._key = self._view(self._pose)
        is_new = np.isin(self._key.ids, new)
        self._landmarks.see(self._key.ids[is_new], self._key.rays[is_new], self._pose)

    def _view(self, pose: Pose) -> View:
        return View(self._tracks.ids.copy(), rays_of(self._tracks.pixels, self._matrix), pose)

    def _expected(self) -> Pixels:
        """Where the corners will be when the camera goes on turning as it does."""
        rays = rays_of(self._tracks.pixels, self._matrix) @ self._turn.T
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
        mask = cv2.resize(white, size, interpolation=cv2.INTER_NEAREST).astype(np.uint8)
        edge = np.ones((_EDGE_PX, _EDGE_PX), np.uint8)
        return cv2.erode(mask, edge, borderValue=(0,)).astype(np.uint8, copy=False)
