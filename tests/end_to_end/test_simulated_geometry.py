"""Calibration and transforms of the simulated headset follow ROS's conventions."""

from __future__ import annotations

import numpy as np
import pytest

from capture_stamps import stamp_ns
from euroc import Matrix, angle_between
from processes import Received
from simulation import CAMERAS, image_topic
from transforms import transforms

# From REP 103's body axes (x forward, y left, z up) to optical axes (x right, y down, z forward).
BODY_IN_OPTICAL = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1]])
SUFFIXES = ("_frame", "_optical_frame")


@pytest.mark.parametrize(
    ("camera", "size", "model", "coefficients"),
    [
        ("world_center", (1016, 1016), "equidistant", 4),
        ("world_left", (1016, 1016), "equidistant", 4),
        ("world_right", (1016, 1016), "equidistant", 4),
        ("color", (1920, 1080), "plumb_bob", 5),
        ("depth", (544, 480), "plumb_bob", 5),
    ],
)
def test_camera_info_is_a_model_that_ros_knows(
    received: Received, camera: str, size: tuple[int, int], model: str, coefficients: int
) -> None:
    for info in received.messages(f"{camera}/camera_info"):
        fx, _, cx, _, fy, cy, *_ = info.k
        assert (info.width, info.height) == size
        assert (info.distortion_model, len(info.d)) == (model, coefficients)
        assert 0 < cx < info.width
        assert 0 < cy < info.height
        assert list(info.k) == [fx, 0, cx, 0, fy, cy, 0, 0, 1]
        assert list(info.r) == [1, 0, 0, 0, 1, 0, 0, 0, 1]
        assert list(info.p) == [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0]
        assert (info.binning_x, info.binning_y, info.roi.width, info.roi.height) == (0, 0, 0, 0)


@pytest.fixture(scope="module")
def tree(received: Received) -> dict[tuple[str, int], Matrix]:
    return transforms(received)


def test_every_frame_is_a_child_of_the_world(tree: dict[tuple[str, int], Matrix]) -> None:
    children = {f"{camera}{suffix}" for camera in CAMERAS for suffix in SUFFIXES}
    found = {child for child, _ in tree if not child.startswith("marker_")}
    assert found == children | {"head_frame", "controller_frame"}


@pytest.mark.parametrize("camera", CAMERAS)
def test_every_image_has_a_transform_and_there_are_more_in_between(
    received: Received, tree: dict[tuple[str, int], Matrix], camera: str
) -> None:
    images = {stamp_ns(image) for image in received.messages(image_topic(camera))}
    known = set(poses(tree, f"{camera}_optical_frame"))
    lost = int(received.counters("/tf")["produced"]) - len(received.messages("/tf"))
    # A busy machine loses some, and requests some colour camera poses too late.
    assert len(images - known) <= lost + len(images) / 10
    assert known - images, "transforms at 60 Hz in addition to the images'"


@pytest.mark.parametrize("camera", CAMERAS)
def test_body_and_optical_frames_differ_only_in_their_axes(
    tree: dict[tuple[str, int], Matrix], camera: str
) -> None:
    optical, body = poses(tree, f"{camera}_optical_frame"), poses(tree, f"{camera}_frame")
    assert optical.keys() == body.keys()
    for stamp, pose in optical.items():
        expected = pose @ BODY_IN_OPTICAL
        assert np.linalg.norm(body[stamp][:3, 3] - expected[:3, 3]) < 1e-9
        assert angle_between(body[stamp], expected) < 1e-9


def poses(tree: dict[tuple[str, int], Matrix], child: str) -> dict[int, Matrix]:
    """Returns the poses of a frame in the world by stamp in ns."""
    return {stamp: pose for (name, stamp), pose in tree.items() if name == child}
