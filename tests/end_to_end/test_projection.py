"""Images agree with the transform tree and the calibration.

Corners of fiducials are detected in received images and compared with their known positions in the
room.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from capture_stamps import stamp_ns
from configurations import only
from counters import have_arrived
from euroc import Matrix
from lenses import project_device, project_ros
from markers import corners
from processes import Received, receive
from simulated_scene import Room, simulated_room
from simulation import image_topic
from transforms import transforms

CAMERAS = ("world_left", "world_center", "world_right", "color")
CONFIG = only(
    """
    world_left: {enabled: true},
    world_center: {enabled: true},
    world_right: {enabled: true},
    picture_center:
      {enabled: true, resolution_width: 1280, resolution_height: 960, update_rate: 15},
    depth_center: {enabled: true, stream: 0, update_rate: 5},
    """
)
IMAGES = 12
# As many of each camera as two loops have with 15 Hz.
RECEIVED = 60
# A busy machine asks too late for poses of most images.
LEAST_TRANSFORMS = 600
LEAST_CORNERS = 300
LEAST_TAGS = 10
LEAST_DEPTHS = 10


@dataclass(frozen=True)
class Sighting:
    """The corners that one image shows, as pixels and as points in the optical frame."""

    tags: set[int]
    pixels: NDArray[np.float64]
    points: NDArray[np.float64]
    intrinsics: dict[str, Any]
    camera_info: Any
    residual_px: float


@pytest.fixture(
    scope="module",
    params=[("0", ""), ("0.001", ""), ("0.001", ", backend: openxr")],
    ids=["straight", "tangential", "openxr"],
)
def projected(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Received:
    folder = tmp_path_factory.mktemp("projection")
    tangential, backend = request.param
    (folder / "config.yaml").write_text(CONFIG.replace("enabled: true", f"enabled: true{backend}"))
    keys = {"tangential": tangential, "depth_noise_m": "0", "noise": "0", "loop_seconds": "2"}
    options = [word for key, value in keys.items() for word in ("--simulate", f"{key}={value}")]
    least = {image_topic(camera): RECEIVED for camera in CAMERAS}
    least |= {"depth/image_raw": LEAST_DEPTHS, "/tf": LEAST_TRANSFORMS}
    return receive(folder / "config.yaml", options, folder, is_enough=have_arrived(least))


@pytest.fixture(scope="module")
def room() -> Room:
    return simulated_room()


@pytest.fixture(scope="module")
def tree(projected: Received) -> dict[tuple[str, int], Matrix]:
    return transforms(projected)


@pytest.fixture(scope="module")
def sightings(
    projected: Received, tree: dict[tuple[str, int], Matrix], room: Room
) -> Callable[[str], list[Sighting]]:
    """Returns the sightings of a camera; they are computed once."""
    return cache(lambda camera: find_sightings(projected, tree, room, camera))


def find_sightings(
    received: Received, tree: dict[tuple[str, int], Matrix], room: Room, camera: str
) -> list[Sighting]:
    """Returns the sightings of up to IMAGES images with pose, calibration and metadata."""
    infos = {stamp_ns(it): it for it in received.messages(f"{camera}/camera_info")}
    metadata = {stamp_ns(it): json.loads(it.data) for it in received.messages(f"{camera}/metadata")}
    optical = f"{camera}_optical_frame"
    images = {stamp_ns(it): it for it in received.messages(image_topic(camera))}
    known = [at for at in images if at in infos and at in metadata and (optical, at) in tree]
    found = []
    for at in known[:: max(1, len(known) // IMAGES)]:
        seen = corners(pixels_of(images[at]))
        if not seen:
            continue
        corners_m = np.array([room.tags[tag][corner] for tag, corner, _ in seen])
        world_in_optical = np.linalg.inv(tree[optical, at])
        found.append(
            Sighting(
                {tag for tag, _, _ in seen},
                np.array([pixel for _, _, pixel in seen]),
                corners_m @ world_in_optical[:3, :3].T + world_in_optical[:3, 3],
                metadata[at]["intrinsics"],
                infos[at],
                metadata[at].get("camera_info_max_residual_px", 0.0),
            )
        )
    assert sum(len(it.pixels) for it in found) >= LEAST_CORNERS
    assert len(set.union(*(it.tags for it in found))) >= LEAST_TAGS
    return found


def pixels_of(image: Any) -> NDArray[np.uint8]:
    """Returns the grey values of an Image or a CompressedImage, height x width."""
    data = np.frombuffer(bytes(image.data), np.uint8)
    if hasattr(image, "format"):
        grey = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
        assert grey is not None
        return grey.astype(np.uint8)
    return data.reshape(image.height, image.step)[:, : image.width].copy()


def errors_px(pixels: NDArray[np.float64], expected: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(pixels - expected, axis=1))


@pytest.mark.parametrize("camera", CAMERAS)
def test_corners_are_where_the_exact_model_puts_them(
    sightings: Callable[[str], list[Sighting]], camera: str
) -> None:
    for it in sightings(camera):
        assert errors_px(it.pixels, project_device(it.intrinsics, it.points)).max() < 0.5


@pytest.mark.parametrize("camera", CAMERAS)
def test_corners_are_where_camera_info_puts_them_but_for_its_residual(
    sightings: Callable[[str], list[Sighting]], camera: str
) -> None:
    for it in sightings(camera):
        errors = errors_px(it.pixels, project_ros(it.camera_info, it.points))
        assert errors.max() < it.residual_px + 0.3


def test_depth_lies_on_the_walls(
    projected: Received, tree: dict[tuple[str, int], Matrix], room: Room
) -> None:
    infos = {stamp_ns(it): it for it in projected.messages("depth/camera_info")}
    images = {stamp_ns(it): it for it in projected.messages("depth/image_raw")}
    known = [at for at in images if at in infos and ("depth_optical_frame", at) in tree]
    assert len(known) >= LEAST_DEPTHS / 2
    hit = np.zeros(len(room.normals), int)
    for at in known[:LEAST_DEPTHS]:
        camera = tree["depth_optical_frame", at]
        points = in_optical_frame(images[at], infos[at]) @ camera[:3, :3].T + camera[:3, 3]
        into_room_m = points @ room.normals.T - room.offsets_m
        assert len(points) > 50_000
        assert into_room_m.min() > -0.01, "nothing is behind a wall"
        from_wall_m = into_room_m.min(axis=1)
        on_wall = from_wall_m < 0.01
        assert on_wall.mean() > 0.6, "the rest is on objects in the room"
        assert (from_wall_m[~on_wall] < 0.03).mean() < 0.05, "walls have no thickness"
        hit += np.bincount(into_room_m[on_wall].argmin(axis=1), minlength=len(hit))
    assert (hit > 10_000).sum() >= 3, "they are on several walls"


def in_optical_frame(image: Any, info: Any) -> NDArray[np.float64]:
    """Returns the valid pixels of a depth image as points, by its CameraInfo."""
    assert image.encoding == "32FC1"
    z = np.frombuffer(bytes(image.data), np.float32).astype(np.float64)
    is_valid = ~np.isnan(z)
    rays = rays_of_pixels(image.width, image.height, tuple(info.k), tuple(info.d))
    return rays[is_valid] * z[is_valid, None]


@cache
def rays_of_pixels(
    width: int, height: int, k: tuple[float, ...], d: tuple[float, ...]
) -> NDArray[np.float64]:
    """Returns the points with z = 1 that all pixels show, in the order of the image's data."""
    rows, columns = np.mgrid[:height, :width]
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1).astype(np.float64)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 40, 1e-9)
    matrix, none = np.array(k).reshape(3, 3), np.eye(3)
    rays = cv2.undistortPointsIter(pixels[:, None], matrix, np.array(d), none, none, stop)
    return np.concatenate([rays[:, 0], np.ones((len(rays), 1))], axis=1)
