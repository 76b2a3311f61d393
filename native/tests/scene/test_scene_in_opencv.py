"""What OpenCV finds in the rendered pictures is where the camera models say it is."""

import json
import subprocess
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

SHOTS = Path(__file__).parents[3] / "build/native/host/tests/scene/scene_shots"
POSES = 10
RUB_TO_OPTICAL = np.diag([1.0, -1.0, -1.0])
"""Camera axes of the headset (y up, z backward) to OpenCV's."""

Points = NDArray[np.float64]


class Truth:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        truth = json.loads((folder / "truth.json").read_text())
        self.shots: list[dict[str, Any]] = truth["shots"]
        self.corners = {tag: np.zeros((4, 3)) for tag, *_ in truth["landmarks"]}
        for tag, corner, *position in truth["landmarks"]:
            self.corners[tag][corner] = position


@pytest.fixture(scope="module", params=[0.0, 1e-3], ids="tangential_{}".format)
def truth(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Truth:
    folder = tmp_path_factory.mktemp("shots")
    subprocess.run([SHOTS, folder, str(request.param), str(POSES)], check=True)
    return Truth(folder)


def rotation(q: list[float]) -> Points:
    x, y, z, w = q
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def project(shot: dict[str, Any], points: Points) -> Points:
    """The camera models of the vendor's documentation, written down independently of the renderer."""
    pose = shot["pose"]
    optical = (points - pose[4:]) @ rotation(pose[:4]) @ RUB_TO_OPTICAL
    (fx, fy), (cx, cy) = shot["f"], shot["c"]
    if "plumb_bob" in shot:
        matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        coefficients = np.array(shot["plumb_bob"])
        return cv2.projectPoints(optical, np.zeros(3), np.zeros(3), matrix, coefficients)[0][:, 0]
    k1, k2, k3, k4, p1, p2 = shot["fisheye"]
    aside = np.hypot(optical[:, 0], optical[:, 1])
    theta = np.arctan2(aside, optical[:, 2])
    bent = theta * (1 + k1 * theta**2 + k2 * theta**4 + k3 * theta**6 + k4 * theta**8)
    x, y = (optical[:, :2] * (bent / aside)[:, None]).T
    q = x**2 + y**2
    xd = x + 2 * p1 * x * y + p2 * (q + 2 * x**2)
    yd = y + p1 * (q + 2 * y**2) + 2 * p2 * x * y
    return np.column_stack([fx * xd + cx, fy * yd + cy])


def found_markers(grey: NDArray[np.uint8]) -> dict[int, Points]:
    """Corners by tag, to a fraction of a pixel; markers less than 30 pixels wide are left out."""
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
    corners, tags, _ = detector.detectMarkers(grey)
    if tags is None:
        return {}
    found = {}
    for tag, square in zip(tags.ravel(), corners, strict=True):
        side = np.linalg.norm(square[0] - np.roll(square[0], 1, axis=0), axis=1).min()
        if side < 30:
            continue
        half = int(np.clip(side / 6 * 0.6, 2, 6))
        stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-4)
        found[int(tag)] = cv2.cornerSubPix(grey, square[0].copy(), (half, half), (-1, -1), stop)
    return found


@pytest.mark.parametrize("camera", ["world_left", "world_center", "world_right", "depth", "color"])
def test_corners_are_where_the_camera_model_puts_them(truth: Truth, camera: str) -> None:
    errors = []
    for shot in truth.shots:
        if shot["camera"] != camera:
            continue
        grey = cv2.imread(str(truth.folder / shot["image"]), cv2.IMREAD_GRAYSCALE)
        found = found_markers(grey)
        assert len(found) >= 4, f"{shot['image']} shows {sorted(found)}"
        for tag, corners in found.items():
            errors.append(np.linalg.norm(corners - project(shot, truth.corners[tag]), axis=1))
    error = np.concatenate(errors)
    print(f"{camera}: {error.size} corners, median {np.median(error):.3f}, max {error.max():.3f}")
    assert np.median(error) < 0.05
    assert error.max() < 0.3


def test_every_tag_is_seen_somewhere_and_no_tag_is_confused(truth: Truth) -> None:
    seen = set()
    for shot in truth.shots:
        grey = cv2.imread(str(truth.folder / shot["image"]), cv2.IMREAD_GRAYSCALE)
        for tag, corners in found_markers(grey).items():
            assert np.linalg.norm(corners - project(shot, truth.corners[tag]), axis=1).max() < 1
            seen.add(tag)
    behind = set(range(40, 46))  # the back wall's
    assert seen >= set(range(50)) - behind
