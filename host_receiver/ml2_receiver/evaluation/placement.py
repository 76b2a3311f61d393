"""Images placed in a map that others have made."""

from __future__ import annotations

import numpy as np
import pycolmap
from numpy.typing import NDArray

from ..export.pose import Pose

_LEAST_POINTS = 12
_LARGEST_ERROR_PX = 4.0


class Map:
    """Points and poses of a reconstruction, and the matches of other images with those in it.

    Args:
        database: has the features and verified matches of all images.
    """

    def __init__(self, model: pycolmap.Reconstruction, database: pycolmap.Database) -> None:
        self._model, self._database = model, database
        self._ids = {image.name: image.image_id for image in database.read_all_images()}
        self._keys = [it.image_id for it in model.images.values() if it.has_pose]

    def pose(self, name: str) -> Pose | None:
        """Of an image's camera in the world of the map; None where it cannot be told."""
        image_id = self._ids.get(name)
        if image_id is None:
            return None
        if image_id in self._keys:
            return _inverse(self._model.image(image_id).cam_from_world())
        pixels, points = self._seen(image_id)
        if len(pixels) < _LEAST_POINTS:
            return None
        options = pycolmap.AbsolutePoseEstimationOptions()
        options.ransac.max_error = _LARGEST_ERROR_PX
        camera = next(iter(self._model.cameras.values()))
        found = pycolmap.estimate_and_refine_absolute_pose(pixels, points, camera, options)
        if found is None or found["num_inliers"] < _LEAST_POINTS:
            return None
        return _inverse(found["cam_from_world"])

    def _seen(self, image_id: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Pixels of an image and the points of the map at them, by its matches with keys."""
        keypoints = self._database.read_keypoints(image_id)
        points: dict[int, NDArray[np.float64]] = {}
        for key in self._matched_keys(image_id):
            features = self._model.image(key).points2D
            geometry = self._database.read_two_view_geometry(image_id, key)
            for mine, theirs in geometry.inlier_matches:
                if features[theirs].has_point3D():
                    points[mine] = self._model.points3D[features[theirs].point3D_id].xyz
        indices = list(points)
        pixels = np.asarray(keypoints)[indices, :2].astype(np.float64)
        return pixels, np.array(list(points.values())).reshape(-1, 3)

    def _matched_keys(self, image_id: int) -> list[int]:
        return [it for it in self._keys if self._database.exists_two_view_geometry(image_id, it)]


def _inverse(camera_from_world: pycolmap.Rigid3d) -> Pose:
    pose = np.eye(4)
    pose[:3] = camera_from_world.inverse().matrix()
    return pose
