"""Places images in a map that was made from other images, the key images."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pycolmap
from numpy.typing import NDArray

from ..geometry.pose import Pose

_LARGEST_ERROR_PX = 2.0
# COLMAP's minima for an image that it takes into a map.
_REGISTRATION = pycolmap.IncrementalMapperOptions()
# A point is triangulated from other images if it is seen by two of them, beside a key image itself.
_LEAST_TRACK = 3
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

        A pose has to reproject the points that are triangulated from other images to where they are
        seen in this one. That of a key image which does not is estimated anew, like that of any
        other image.

        Args:
            neighbours: other key images with the same view; their points are searched in the image.
        """
        if name in self._keys:
            pose = self._keys[name].cam_from_world()
            if self._agrees(pose, *self._points(name)):
                return _inverse(pose)
        image = self._image(name)
        tracked = [self._track(image, key) for key in neighbours if key in self._keys]
        pixels = np.concatenate([np.empty((0, 2)), *(pixels for pixels, _ in tracked)])
        points = np.concatenate([np.empty((0, 3)), *(points for _, points in tracked)])
        options = pycolmap.AbsolutePoseEstimationOptions()
        options.ransac.max_error = _LARGEST_ERROR_PX
        found = pycolmap.estimate_and_refine_absolute_pose(pixels, points, self._camera, options)
        # The inliers of RANSAC are those of the pose before its refinement.
        if found is None or not self._agrees(found["cam_from_world"], pixels, points):
            return None
        return _inverse(found["cam_from_world"])

    def _agrees(self, pose: pycolmap.Rigid3d, pixels: Points, points: Points) -> bool:
        """Returns True if enough of the points are seen where the pose has them."""
        # NaN for points behind the camera
        errors_px = np.linalg.norm(self._camera.img_from_cam(pose * points) - pixels, axis=1)
        inliers = np.count_nonzero(errors_px <= _LARGEST_ERROR_PX)
        return bool(
            inliers >= _REGISTRATION.abs_pose_min_num_inliers
            and inliers >= _REGISTRATION.abs_pose_min_inlier_ratio * len(points)
        )

    def _points(self, key: str) -> tuple[Points, Points]:
        """Returns the pixels of the points that a key image sees, n x 2, and the points, n x 3."""
        seen = [
            (it.xy, point.xyz)
            for it in self._keys[key].points2D
            if it.has_point3D()
            and (point := self._model.points3D[it.point3D_id]).track.length() >= _LEAST_TRACK
        ]
        pixels, points = zip(*seen, strict=True) if seen else ((), ())
        return np.reshape(pixels, (-1, 2)), np.reshape(points, (-1, 3))

    def _track(self, image: NDArray[np.uint8], key: str) -> tuple[Points, Points]:
        """Tracks the map points of a key image into `image`; returns those found, as _points()."""
        pixels, points = self._points(key)
        if not len(pixels):
            return pixels, points
        before = pixels.astype(np.float32) - _HALF
        found, is_found, _ = cv2.calcOpticalFlowPyrLK(
            self._image(key),
            image,
            before,
            np.empty_like(before),
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
