"""Places images in a map that was made from other images, the key images."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pycolmap
from numpy.typing import NDArray

from ..geometry.pose import Pose

_LEAST_POINTS = 12
_LARGEST_ERROR_PX = 2.0
_WINDOW_PX, _LEVELS = (21, 21), 4
# COLMAP's pixel centres are at halves, OpenCV's at whole numbers.
_HALF = np.float32(0.5)

type Points = NDArray[np.float64]


class Map:
    """The points and key images of a reconstruction.

    Args:
        folder: the folder of all images, by name.
    """

    def __init__(self, model: pycolmap.Reconstruction, folder: Path) -> None:
        self._model, self._folder = model, folder
        self._keys = {it.name: it for it in model.images.values() if it.has_pose}
        (self._camera,) = model.cameras.values()

    def pose(self, name: str, neighbours: Sequence[str]) -> Pose | None:
        """Returns the pose of an image's camera in the map's world, or None if it is not found.

        Args:
            neighbours: key images with the same view; their points are searched in the image.
        """
        if name in self._keys:
            return _inverse(self._keys[name].cam_from_world())
        image = self._image(name)
        tracked = [self._track(image, key) for key in neighbours if key in self._keys]
        pixels = np.concatenate([np.empty((0, 2)), *(pixels for pixels, _ in tracked)])
        points = np.concatenate([np.empty((0, 3)), *(points for _, points in tracked)])
        if len(pixels) < _LEAST_POINTS:
            return None
        options = pycolmap.AbsolutePoseEstimationOptions()
        options.ransac.max_error = _LARGEST_ERROR_PX
        found = pycolmap.estimate_and_refine_absolute_pose(pixels, points, self._camera, options)
        if found is None or found["num_inliers"] < _LEAST_POINTS:
            return None
        return _inverse(found["cam_from_world"])

    def _track(self, image: NDArray[np.uint8], key: str) -> tuple[Points, Points]:
        """Tracks the map points of a key image into `image`.

        Returns:
            Their pixels, n x 2, and their positions in the world, n x 3.
        """
        features = [it for it in self._keys[key].points2D if it.has_point3D()]
        if not features:
            return np.empty((0, 2)), np.empty((0, 3))
        pixels = np.array([it.xy for it in features], np.float32) - _HALF
        points = np.array([self._model.points3D[it.point3D_id].xyz for it in features])
        found, is_found, _ = cv2.calcOpticalFlowPyrLK(
            self._image(key),
            image,
            pixels,
            np.empty_like(pixels),
            winSize=_WINDOW_PX,
            maxLevel=_LEVELS,
        )
        is_seen = np.asarray(is_found).ravel() == 1
        return np.asarray(found, np.float64)[is_seen] + _HALF, points[is_seen]

    def _image(self, name: str) -> NDArray[np.uint8]:
        image = cv2.imread(str(self._folder / name), cv2.IMREAD_GRAYSCALE)
        assert image is not None
        return image.astype(np.uint8, copy=False)


def _inverse(camera_from_world: pycolmap.Rigid3d) -> Pose:
    pose = np.eye(4)
    pose[:3] = camera_from_world.inverse().matrix()
    return pose
