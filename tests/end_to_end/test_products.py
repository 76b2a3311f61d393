"""The output of `ml2-receiver products` agrees with the simulated room."""

from __future__ import annotations

import json
from bisect import bisect
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from capture_stamps import stamp_ns
from configurations import only
from euroc import Matrix
from lenses import project_device, project_ros
from markers import corners
from other_programs import collect, streaming
from processes import RECEIVER, Received, process
from simulated_scene import Room, simulated_room
from transforms import transforms
from waiting import LIMIT_S

SECTIONS = """
    world_left: {enabled: true},
    picture_center: {enabled: true, resolution_width: 1280, resolution_height: 960},
    depth_center: {enabled: true, stream: 0, update_rate: 5, radial: RADIAL},
"""
# So many messages of each topic are collected. A busy machine drops some of what they are made of,
# so fewer have all that is asked for.
COUNT, LEAST = 12, 3
IMAGE, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
TOPICS = {
    "depth/points": "sensor_msgs/msg/PointCloud2",
    "world_left/image_rect": IMAGE,
    "aligned_depth_to_color/image_raw": IMAGE,
    "aligned_depth_to_color/camera_info": INFO,
    "aligned_depth_to_world_left/image_raw": IMAGE,
    "aligned_depth_to_world_left/camera_info": INFO,
    "depth/camera_info": INFO,
    "color/camera_info": INFO,
    "world_left/camera_info": INFO,
    "world_left/metadata": "std_msgs/msg/String",
    "/tf": "tf2_msgs/msg/TFMessage",
}


@pytest.fixture(scope="module", params=["false", "true"], ids=["z", "radial"])
def products(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Received:
    folder = tmp_path_factory.mktemp("products")
    config = folder / "config.yaml"
    config.write_text(only(SECTIONS.replace("RADIAL", request.param)))
    return receive_products(config, folder)


def receive_products(config: Path, folder: Path) -> Received:
    with (
        streaming(
            config, folder, tangential="0.001", depth_noise_m="0", noise="0", loop_seconds="2"
        ) as domain,
        process([RECEIVER, "products"], domain, folder / "products.log") as making,
    ):
        received = collect(TOPICS, COUNT, domain, folder)
        making.terminate()
        assert making.wait(LIMIT_S) == 0
    assert "Traceback" not in (folder / "products.log").read_text()
    return received


@pytest.fixture(scope="module")
def tree(products: Received) -> dict[tuple[str, int], Matrix]:
    return transforms(products)


@pytest.fixture(scope="module")
def room() -> Room:
    return simulated_room()


def located(
    products: Received, tree: dict[tuple[str, int], Matrix], topic: str
) -> list[tuple[Any, Matrix]]:
    """Returns the messages of a topic, each with the pose of its frame at its stamp."""
    messages = products.messages(topic)
    known = [
        (it, tree[it.header.frame_id, stamp_ns(it)])
        for it in messages
        if (it.header.frame_id, stamp_ns(it)) in tree
    ]
    assert len(known) >= LEAST
    return known


def assert_on_walls(points: NDArray[np.float64], pose: Matrix, room: Room) -> None:
    """Asserts that most points, in the frame at `pose`, are on walls, and none behind a wall."""
    normals = room.normals @ pose[:3, :3]
    offsets_m = room.offsets_m - room.normals @ pose[:3, 3]
    from_wall_m = (normals @ points.T - offsets_m[:, None]).min(axis=0)
    assert from_wall_m.min() > -0.01, "nothing is behind a wall"
    assert (from_wall_m < 0.01).mean() > 0.6


def floats(image: Any) -> NDArray[np.float32]:
    assert image.encoding == "32FC1"
    return np.frombuffer(bytes(image.data), np.float32).reshape(image.height, image.width)


def test_points_are_on_the_walls(
    products: Received, tree: dict[tuple[str, int], Matrix], room: Room
) -> None:
    for cloud, pose in located(products, tree, "depth/points"):
        assert (cloud.width, cloud.height, cloud.is_dense) == (544, 480, False)
        rows = np.frombuffer(bytes(cloud.data), np.float32).reshape(-1, cloud.point_step // 4)
        points = rows[:, :3].astype(np.float64)
        points = points[~np.isnan(points[:, 2])]
        assert len(points) > 50_000
        assert_on_walls(points, pose, room)


def test_points_have_the_colour_of_the_room(
    products: Received, tree: dict[tuple[str, int], Matrix], room: Room
) -> None:
    """The fiducials' black borders are darker than the white around them."""
    clouds = [it for it in products.messages("depth/points") if len(it.fields) == 4]
    assert len(clouds) >= LEAST
    contrasts = []
    for cloud in clouds:
        at = ("depth_optical_frame", stamp_ns(cloud))
        if at not in tree:
            continue
        rows = np.frombuffer(bytes(cloud.data), np.float32).reshape(-1, 4)
        rows = rows[np.ascontiguousarray(rows[:, 3]).view(np.uint32) != 0]
        pose = tree[at]
        points = rows[:, :3].astype(np.float64) @ pose[:3, :3].T + pose[:3, 3]
        packed = np.ascontiguousarray(rows[:, 3]).view(np.uint32)
        grey = (packed >> 8 & 0xFF).astype(float)
        for tag in room.tags.values():
            border, around = tag_parts(points, tag)
            if len(border) > 20 and len(around) > 20:
                contrasts.append(np.median(grey[around]) - np.median(grey[border]))
    assert len(contrasts) >= 5
    assert min(contrasts) > 40, "the black border is where the tag is"


def tag_parts(
    points: NDArray[np.float64], tag: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Returns the indices of points on a marker's black border, and on the white around."""
    origin, right, _, down = tag
    across, along = right - origin, down - origin
    side_m = float(np.linalg.norm(across))
    normal = np.cross(across, along) / side_m**2
    near = np.flatnonzero(np.abs(points @ normal - origin @ normal) < 0.02)
    cell = 1 / 6
    u = (points[near] - origin) @ across / side_m**2 - 0.5
    is_beside = np.abs(u) < 0.5 + 0.7 * cell
    near, u = near[is_beside], u[is_beside]
    v = (points[near] - origin) @ along / side_m**2 - 0.5
    from_centre = np.maximum(np.abs(u), np.abs(v))
    border = (from_centre < 0.5 - 0.3 * cell) & (from_centre > 0.5 - 0.7 * cell)
    around = (from_centre > 0.5 + 0.3 * cell) & (from_centre < 0.5 + 0.7 * cell)
    return near[border], near[around]


def test_corners_in_a_rectified_image_are_where_p_puts_them(
    products: Received, tree: dict[tuple[str, int], Matrix], room: Room
) -> None:
    (p, *_) = {tuple(it.p) for it in products.messages("world_left/camera_info")}
    matrix = np.array(p).reshape(3, 4)
    count = 0
    for image, pose in located(products, tree, "world_left/image_rect")[::3]:
        assert image.encoding == "mono8"
        grey = np.frombuffer(bytes(image.data), np.uint8).reshape(image.height, image.width)
        seen = corners(grey)
        count += len(seen)
        for tag, corner, pixel in seen:
            point = np.linalg.inv(pose) @ [*room.tags[tag][corner], 1]
            expected = matrix @ [*point[:3], 1]
            assert np.abs(pixel - expected[:2] / expected[2]).max() < 0.5
    assert count > 50


@pytest.mark.parametrize("camera", ["color", "world_left"])
def test_registered_depth_is_on_the_walls_as_the_other_camera_sees_them(
    products: Received, tree: dict[tuple[str, int], Matrix], room: Room, camera: str
) -> None:
    """Projects tags' centres with the camera's exact model, and compares their z with the image."""
    topic = f"aligned_depth_to_{camera}"
    infos = {stamp_ns(it): it for it in products.messages(f"{topic}/camera_info")}
    metadata = {
        stamp_ns(it): json.loads(it.data)["intrinsics"]
        for it in products.messages("world_left/metadata")
    }
    originals = sorted(stamp_ns(it) for it in products.messages(f"{camera}/camera_info"))
    errors = []
    for image, pose in located(products, tree, f"{topic}/image_raw"):
        at = stamp_ns(image)
        assert image.header.frame_id == f"{camera}_optical_frame"
        assert at in originals or is_in_a_gap(at, originals), "it has the stamp of an image"
        if at not in infos or (camera == "world_left" and at not in metadata):
            continue
        z, info = floats(image), infos[at]
        assert (info.width, info.height) == (image.width, image.height)
        for corners_m in room.tags.values():
            centre = np.linalg.inv(pose) @ [*corners_m.mean(axis=0), 1]
            if centre[2] < 0.6:
                continue
            point = centre[None, :3]
            pixel = (
                project_ros(info, point)
                if camera == "color"
                else project_device(metadata[at], point)
            )[0]
            column, row = np.round(pixel).astype(int)
            if (
                0 <= row < image.height
                and 0 <= column < image.width
                and not np.isnan(z[row, column])
            ):
                errors.append(z[row, column] - centre[2])
    assert len(errors) >= 10
    assert np.median(np.abs(errors)) < 0.01
    assert max(errors) < 0.03, "nothing is seen through a wall"


def is_in_a_gap(at: int, arrived: list[int]) -> bool:
    """Returns True if a stamp is in a gap of the others, so that its message may be lost."""
    after = bisect(arrived, at)
    if after in (0, len(arrived)):
        return True
    return bool(arrived[after] - arrived[after - 1] > 1.5 * np.median(np.diff(arrived)))
