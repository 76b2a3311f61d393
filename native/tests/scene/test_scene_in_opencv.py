"""OpenCV finds corners in rendered pictures where the camera models place them."""

import json
import subprocess
from dataclasses import dataclass
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

Points = NDArray[Any]


@dataclass
class Corner:
    tag: int
    found: Points
    expected: Points

    @property
    def error(self) -> float:
        return float(np.linalg.norm(self.found - self.expected))


class Truth:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        truth = json.loads((folder / "truth.json").read_text())
        self.shots: list[dict[str, Any]] = truth["shots"]
        self.landmarks = np.array(truth["landmarks"])  # tag, corner, x, y, z

    def corners(self, shot: dict[str, Any]) -> list[Corner]:
        """Returns the corners of the tags that OpenCV reads.

        Left out are corners beside a box's edge or the image's, and those seen so aslant that the
        window of the search holds more than the corner.
        """
        grey = cv2.imread(str(self.folder / shot["image"]), cv2.IMREAD_GRAYSCALE)
        height, width = grey.shape
        expected = project(shot, self.landmarks[:, 2:])
        corners = []
        for tag, square in read_markers(grey).items():
            for corner, rough in enumerate(square):
                index = 4 * tag + corner
                u, v = expected[index]
                is_inside = 10 <= u < width - 10 and 10 <= v < height - 10
                if is_inside and index in shot["clear"] and 55 < angle(square, corner) < 125:
                    cell = shortest_side(square) / 6
                    assert np.linalg.norm(rough - expected[index]) < 3 * cell
                    found = saddle(grey, expected[index], int(np.clip(0.6 * cell, 2, 6)))
                    corners.append(Corner(tag, found, expected[index]))
        return corners


@pytest.fixture(scope="module", params=[0.0, 1e-3], ids="tangential_{}".format)
def truth(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Truth:
    folder = tmp_path_factory.mktemp("shots")
    subprocess.run([SHOTS, folder, str(request.param), str(POSES)], check=True)
    return Truth(folder)


def rotation(q: list[float]) -> Points:
    x, y, z, w = q
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix: Points = np.eye(3) + 2 * w * cross + 2 * cross @ cross
    return matrix


def project(shot: dict[str, Any], points: Points) -> Points:
    """The camera models of the vendor's documentation, written down independently."""
    pose = shot["pose"]
    optical = (points - pose[4:]) @ rotation(pose[:4]) @ RUB_TO_OPTICAL
    (fx, fy), (cx, cy) = shot["f"], shot["c"]
    if "plumb_bob" in shot:
        matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        coefficients = np.array(shot["plumb_bob"])
        still = np.zeros(3)
        pixels: Points = cv2.projectPoints(optical, still, still, matrix, coefficients)[0][:, 0]
        return pixels
    k1, k2, k3, k4, p1, p2 = shot["fisheye"]
    aside = np.hypot(optical[:, 0], optical[:, 1])
    theta = np.arctan2(aside, optical[:, 2])
    bent = theta * (1 + k1 * theta**2 + k2 * theta**4 + k3 * theta**6 + k4 * theta**8)
    x, y = (optical[:, :2] * (bent / aside)[:, None]).T
    q = x**2 + y**2
    xd = x + 2 * p1 * x * y + p2 * (q + 2 * x**2)
    yd = y + p1 * (q + 2 * y**2) + 2 * p2 * x * y
    return np.column_stack([fx * xd + cx, fy * yd + cy])


def read_markers(grey: NDArray[Any]) -> dict[int, Points]:
    """Rough corners by tag; markers less than 30 pixels wide are left out."""
    parameters = cv2.aruco.DetectorParameters()
    # Black squares touch the markers' corners; with less their outlines often run into each other.
    parameters.adaptiveThreshConstant = 40
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    squares, tags, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(grey)
    found = {}
    for tag, square in zip([] if tags is None else tags.ravel(), squares, strict=True):
        if shortest_side(square[0]) >= 30:
            found[int(tag)] = square[0]
    return found


def angle(square: Points, corner: int) -> float:
    after, before = square[(corner + 1) % 4] - square[corner], square[corner - 1] - square[corner]
    cosine = after @ before / np.linalg.norm(after) / np.linalg.norm(before)
    return float(np.degrees(np.arccos(cosine)))


def shortest_side(square: Points) -> float:
    return float(np.linalg.norm(square - np.roll(square, 1, axis=0), axis=1).min())


def saddle(grey: NDArray[Any], near: Points, half: int) -> Points:
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-4)
    start = near.astype(np.float32).reshape(1, 1, 2)
    found: Points = cv2.cornerSubPix(grey, start, (half, half), (-1, -1), stop)[0, 0]
    return found


@pytest.mark.parametrize("camera", ["world_left", "world_center", "world_right", "depth", "color"])
def test_corners_are_where_the_camera_model_puts_them(truth: Truth, camera: str) -> None:
    corners = []
    for shot in truth.shots:
        if shot["camera"] == camera:
            seen = truth.corners(shot)
            tags = {corner.tag for corner in seen}
            assert len(tags) >= 4, f"{shot['image']} shows {tags}"
            corners += seen
    errors = np.array([corner.error for corner in corners])
    assert np.median(errors) < 0.05
    assert errors.max() < 0.3, max(corners, key=lambda corner: corner.error)


def test_all_fifty_tags_are_read_by_looking_around(truth: Truth) -> None:
    around = [shot for shot in truth.shots if shot["camera"] == "around"]
    seen = {corner.tag for shot in around for corner in truth.corners(shot)}
    assert set(range(50)) - seen == set()


def test_feature_detectors_find_hundreds_of_corners_all_over_the_picture(truth: Truth) -> None:
    fast = cv2.FastFeatureDetector.create(threshold=20)
    for shot in truth.shots:
        if shot["camera"].startswith("world"):
            grey = cv2.imread(str(truth.folder / shot["image"]), cv2.IMREAD_GRAYSCALE)
            u, v = np.array([point.pt for point in fast.detect(grey)]).T
            counts = np.histogram2d(u, v, bins=4, range=[[0, 1016], [0, 1016]])[0]
            assert counts.sum() > 1000
            assert (counts > 10).sum() >= 14, f"{shot['image']}: {counts}"


@pytest.mark.parametrize(
    ("kind", "dictionary"),
    [(1, cv2.aruco.DICT_5X5_100), (2, cv2.aruco.DICT_APRILTAG_36h11)],
    ids=["ArUco", "AprilTag"],
)
def test_tags_from_near_have_the_poses_that_opencv_estimates(
    tmp_path: Path, kind: int, dictionary: int
) -> None:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(dictionary), parameters)
    truth = near(tmp_path, kind)
    errors = []
    for shot in truth.shots:
        grey = cv2.imread(str(tmp_path / shot["image"]), cv2.IMREAD_GRAYSCALE)
        squares, tags, _ = detector.detectMarkers(grey)
        for tag, square in zip([] if tags is None else tags.ravel(), squares, strict=True):
            assert tag < 50, "a false detection"
            error = pose_error(shot, square[0], truth.landmarks[4 * tag : 4 * tag + 4, 2:])
            if error is not None:
                errors.append(error)
    assert len(errors) >= 200
    metres, degrees = np.median(errors, axis=0)
    assert metres < 0.005
    assert degrees < 0.5


def test_qr_codes_from_near_say_which_they_are(tmp_path: Path) -> None:
    reader = cv2.QRCodeDetectorAruco()
    truth = near(tmp_path, 3)
    shots = [shot for shot in truth.shots if shot["camera"] == "near"]
    assert len(shots) == 8
    for shot in shots:
        grey = cv2.imread(str(tmp_path / shot["image"]), cv2.IMREAD_GRAYSCALE)
        texts = reader.detectAndDecodeMulti(rectified(shot, grey))[1]
        assert f"ml2-{shot['image'].split('_')[0]}" in texts


def rectified(shot: dict[str, Any], grey: NDArray[Any]) -> NDArray[Any]:
    """Returns the middle of a picture without its distortion, as readers of QR codes expect."""
    across, down = np.meshgrid(np.linspace(-0.6, 0.6, 600), np.linspace(-0.6, 0.6, 600))
    rays = np.column_stack([across.ravel(), down.ravel(), np.ones(across.size)])
    points = rays @ (rotation(shot["pose"][:4]) @ RUB_TO_OPTICAL).T + shot["pose"][4:]
    u, v = project(shot, points).T.astype(np.float32).reshape(2, *across.shape)
    return cv2.remap(grey, u, v, cv2.INTER_LINEAR)


def near(folder: Path, kind: int) -> Truth:
    subprocess.run([SHOTS, folder, "1e-4", "0", str(kind)], check=True)
    return Truth(folder)


def pose_error(shot: dict[str, Any], square: Points, corners: Points) -> tuple[float, float] | None:
    """Compares OpenCV's pose of a tag with its place, in metres and degrees; only 0.5 to 2 m away.

    The frame of the tag is that of the simulated detector: x right, y up, z out of the face.
    """
    side = float(np.linalg.norm(corners[1] - corners[0]))
    x, y = (corners[1] - corners[0]) / side, (corners[0] - corners[3]) / side
    center, axes = corners.mean(axis=0), np.column_stack([x, y, np.cross(x, y)])
    to_optical = RUB_TO_OPTICAL @ rotation(shot["pose"][:4]).T
    expected = to_optical @ (center - shot["pose"][4:])
    if not 0.5 <= np.linalg.norm(expected) <= 2:
        return None
    half = side / 2
    own = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    _, turned, found = cv2.solvePnP(
        own, unproject(shot, square), np.eye(3), np.zeros(4), flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    difference = cv2.Rodrigues(cv2.Rodrigues(turned)[0] @ (to_optical @ axes).T)[0]
    metres = float(np.linalg.norm(found[:, 0] - expected))
    return metres, float(np.degrees(np.linalg.norm(difference)))


def unproject(shot: dict[str, Any], pixels: Points) -> Points:
    """Inverts the model of the world cameras; the result is on the plane z = 1."""
    k1, k2, k3, k4, p1, p2 = shot["fisheye"]
    distorted = (pixels.astype(float) - shot["c"]) / shot["f"]
    bent = distorted.copy()
    for _ in range(20):
        x, y = bent.T
        q = x**2 + y**2
        aside = [2 * p1 * x * y + p2 * (q + 2 * x**2), p1 * (q + 2 * y**2) + 2 * p2 * x * y]
        bent = distorted - np.column_stack(aside)
    radius = np.linalg.norm(bent, axis=1)
    theta = radius.copy()
    for _ in range(20):
        theta = radius / (1 + k1 * theta**2 + k2 * theta**4 + k3 * theta**6 + k4 * theta**8)
    plane: Points = bent / radius[:, None] * np.tan(theta)[:, None]
    return plane
