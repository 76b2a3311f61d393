"""Markers of the headset's own detector, against the room and against OpenCV's detector.

OpenCV finds them in the published images, and places them by camera_info and /tf.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from bags import message_counts
from capture_stamps import stamp_ns
from configurations import only
from counters import have_arrived
from euroc import Matrix, pose_matrix
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.bags.decoding import decoder
from processes import (
    PREFIX,
    RECEIVER,
    Received,
    ended,
    isolated_environment,
    listening_address,
    process,
    receive,
    recorded_walk,
)
from simulated_scene import Room, simulated_room
from test_projection import pixels_of
from transforms import transforms

SIDE_M = 0.48
IMAGES = 120
NEAR_M, FAR_M = 0.5, 2.0
NEAREST_SEEN_M = 0.7
CONFIG = only(
    f"""
    world_center: {{enabled: true}},
    markers: {{enabled: true, type: aruco, dictionary: 5X5_100, size_m: {SIDE_M}}},
    """
)


@dataclass(frozen=True)
class Difference:
    """The difference of two poses of a marker, in the camera's frame."""

    away_m: float
    moved_m: float
    turned_deg: float


@pytest.fixture(scope="module")
def received(tmp_path_factory: pytest.TempPathFactory) -> Received:
    folder = tmp_path_factory.mktemp("markers")
    (folder / "config.yaml").write_text(CONFIG)
    (folder / "path.tum").write_text(path_along_the_front_wall())
    keys = ("noise=0", f"trajectory={folder / 'path.tum'}", "tags=5X5_100")
    options = [word for key in keys for word in ("--simulate", key)]
    least = {"world_center/image_raw": IMAGES, "markers": IMAGES}
    return receive(folder / "config.yaml", options, folder, is_enough=have_arrived(least))


def path_along_the_front_wall() -> str:
    """Returns a path of 3 s in TUM's format that looks at tags of the wall at x = 3.5 m."""
    lines = []
    for step in range(31):
        turn = 2 * np.pi * step / 30
        x, y, yaw = 2.2 - 0.75 * np.cos(turn), 0.47 + 0.5 * np.sin(turn), 0.2 * np.sin(2 * turn)
        lines.append(f"{step / 10} {x} {y} 0.4 0 0 {np.sin(yaw / 2)} {np.cos(yaw / 2)}\n")
    return "".join(lines)


@pytest.fixture(scope="module")
def tree(received: Received) -> dict[tuple[str, int], Matrix]:
    return transforms(received)


@pytest.fixture(scope="module")
def room() -> Room:
    return simulated_room()


def as_laid_out(corners_m: NDArray[np.float64]) -> Matrix:
    """Returns the pose of a marker by its corners, clockwise from the top left."""
    right, up = (corners_m[1] - corners_m[0]), (corners_m[0] - corners_m[3])
    right, up = right / np.linalg.norm(right), up / np.linalg.norm(up)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, up, np.cross(right, up)], axis=1)
    pose[:3, 3] = corners_m.mean(axis=0)
    return pose


def turned_deg(one: Matrix, other: Matrix) -> float:
    rotation, _ = cv2.Rodrigues(one[:3, :3].T @ other[:3, :3])
    return float(np.degrees(np.linalg.norm(rotation)))


def markers_of(tree: dict[tuple[str, int], Matrix]) -> dict[str, list[Matrix]]:
    found: dict[str, list[Matrix]] = {}
    for (frame, _), pose in tree.items():
        if frame.startswith("marker_"):
            found.setdefault(frame, []).append(pose)
    return found


def test_markers_are_where_they_hang(tree: dict[tuple[str, int], Matrix], room: Room) -> None:
    markers = markers_of(tree)
    assert len(markers) >= 3
    for frame, poses in markers.items():
        expected = as_laid_out(room.tags[int(frame.removeprefix("marker_"))])
        for pose in poses:
            assert np.linalg.norm(pose[:3, 3] - expected[:3, 3]) < 1e-4
            assert turned_deg(pose, expected) < 0.01


def test_detections_have_the_transforms_of_their_stamp(
    received: Received, tree: dict[tuple[str, int], Matrix]
) -> None:
    assert received.snapshot["streams"]["markers"]["result"] == "applied"
    seen = 0
    for message in received.messages("markers"):
        assert message.header.frame_id == "magicleap_world"
        for it in message.detections:
            (result,) = it.results
            assert it.id == f"marker_{result.hypothesis.class_id}"
            assert [it.bbox.size.x, it.bbox.size.y] == pytest.approx([SIDE_M, SIDE_M])
            transform = tree.get((it.id, stamp_ns(message)))
            if transform is None:  # received before or after the others
                continue
            place = result.pose.pose.position
            assert [place.x, place.y, place.z] == pytest.approx(transform[:3, 3])
            seen += 1
    assert seen > IMAGES


def test_opencv_places_them_likewise_by_images_calibration_and_transforms(
    received: Received, tree: dict[tuple[str, int], Matrix]
) -> None:
    differences = compared(received, tree)
    assert len(differences) >= IMAGES / 2
    assert min(it.away_m for it in differences) < NEAREST_SEEN_M
    assert float(np.median([it.moved_m for it in differences])) < 5e-3
    assert float(np.median([it.turned_deg for it in differences])) < 0.5


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a walk along AprilTags, made without ROS."""
    folder = tmp_path_factory.mktemp("recording")
    (folder / "config.yaml").write_text(only(f"markers: {{enabled: true, size_m: {SIDE_M}}}"))
    options = ("--simulate", "noise=0", "--simulate", "tags=36h11")
    return recorded_walk(folder / "config.yaml", folder, has_detections, *options)


def recorded(bag: Path, topic: str, type: str) -> list[Any]:
    reader = BagReader(bag)
    assert reader.types[topic] == type
    return [decoder(type)(it.payload) for it in reader.messages() if it.topic == topic]


def detections(bag: Path) -> list[Any]:
    arrays = recorded(bag, f"{PREFIX}/markers", "vision_msgs/msg/Detection3DArray")
    return [it for array in arrays for it in array.detections]


def test_a_recording_has_april_tags_by_the_names_and_axes_of_apriltag_ros(
    bag: Path, room: Room
) -> None:
    seen = {it.id: it for it in detections(bag)}
    transforms = recorded(bag, "/tf", "tf2_msgs/msg/TFMessage")
    assert len(seen) >= 3
    assert seen.keys() <= {it.child_frame_id for found in transforms for it in found.transforms}
    half_a_turn = np.diag([1.0, -1.0, -1.0])
    for frame, it in seen.items():
        expected = as_laid_out(room.tags[int(frame.removeprefix("tag36h11:"))])
        expected[:3, :3] @= half_a_turn
        place, turn = it.bbox.center.position, it.bbox.center.orientation
        pose = pose_matrix([place.x, place.y, place.z], turn.w, turn.x, turn.y, turn.z)
        assert np.linalg.norm(pose[:3, 3] - expected[:3, 3]) < 1e-4
        assert turned_deg(pose, expected) < 0.01


def test_a_played_recording_has_the_same_detections(bag: Path, tmp_path: Path) -> None:
    again, environment = tmp_path / "again", isolated_environment()
    record: list[str | Path] = [RECEIVER, "record", again, "--no-ros"]
    record += ["--config", bag.parent / "config.yaml", "--listen", "127.0.0.1:0", "--insecure"]
    with process(record, environment, tmp_path / "receiver.log") as receiver:
        play: list[str | Path] = [RECEIVER, "play", bag, "--receiver", listening_address(receiver)]
        play += ["--insecure", "--rate", "5"]
        ended(play, environment).check_returncode()
    assert [shown(it) for it in detections(again)] == [shown(it) for it in detections(bag)]


def shown(detection: Any) -> tuple[str, Any, Any]:
    (result,) = detection.results
    return detection.id, detection.bbox.center, result.hypothesis.class_id


def has_detections(bag: Path) -> bool:
    counts = message_counts(bag)
    return min(counts.get(f"{PREFIX}/markers", 0), counts.get("/tf", 0)) > IMAGES


def compared(received: Received, tree: dict[tuple[str, int], Matrix]) -> list[Difference]:
    infos = {stamp_ns(it): it for it in received.messages("world_center/camera_info")}
    published = {frame: poses[0] for frame, poses in markers_of(tree).items()}
    found = []
    for image in received.messages("world_center/image_raw"):
        at = stamp_ns(image)
        camera = tree.get(("world_center_optical_frame", at))
        if at not in infos or camera is None:
            continue
        for frame, in_camera in detected(pixels_of(image), infos[at]):
            away_m = float(np.linalg.norm(in_camera[:3, 3]))
            if frame in published and NEAR_M <= away_m <= FAR_M:
                pose = camera @ in_camera
                moved_m = float(np.linalg.norm(pose[:3, 3] - published[frame][:3, 3]))
                found.append(Difference(away_m, moved_m, turned_deg(pose, published[frame])))
    return found


def detected(grey: NDArray[np.uint8], info: Any) -> list[tuple[str, Matrix]]:
    """Returns the frames of the markers that OpenCV finds, and their poses in the camera."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    quads, ids, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(grey)
    half = SIDE_M / 2
    square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    assert info.distortion_model == "equidistant"
    found = []
    for quad, tag in zip(quads, ids.ravel() if ids is not None else [], strict=True):
        matrix, lens = np.array(info.k).reshape(3, 3), np.array(info.d)
        flat = cv2.fisheye.undistortPoints(quad.reshape(4, 1, 2).astype(np.float64), matrix, lens)
        _, turns, places, _ = cv2.solvePnPGeneric(
            square, flat, np.eye(3), np.zeros(4), flags=cv2.SOLVEPNP_IPPE_SQUARE
        )
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turns[0])[0], places[0].ravel()
        found.append((f"marker_{tag}", pose))
    return found
