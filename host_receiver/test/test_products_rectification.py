"""Against OpenCV's own maps, and edges whose straight images are known."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo

from ml2_tools.geometry.camera import Camera, camera_of
from ml2_tools.geometry.lens import Lens
from ml2_tools.images.rectification import rectify

MATRIX = np.array([[300.0, 0, 160], [0, 301, 118], [0, 0, 1]])
SIZE = (320, 240)
PLUMB_BOB = np.array([-0.2, 0.05, 1e-3, -1e-3, 0.01])
EQUIDISTANT = np.array([0.05, -0.02, 0.01, -3e-3])
TILT = cv2.Rodrigues(np.array([0.02, -0.03, 0.01]))[0]


def camera(
    model: str,
    coefficients: NDArray[np.float64],
    rotation: NDArray[Any] = np.eye(3),  # noqa: B008
    new: NDArray[Any] = MATRIX,
) -> Camera:
    lens = Lens(*SIZE, 300.0, 301.0, 160.0, 118.0, model, tuple(coefficients))
    return Camera(lens, tuple(rotation.ravel().tolist()), tuple(new.ravel().tolist()))


def smooth_image() -> NDArray[np.uint8]:
    noise = np.random.default_rng(1).integers(0, 255, (*SIZE[::-1], 3)).astype(np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 4).astype(np.uint8)


@pytest.mark.parametrize("rotation", [np.eye(3), TILT], ids=["straight", "tilted"])
@pytest.mark.parametrize("model", ["plumb_bob", "equidistant"])
def test_an_image_is_rectified_as_opencv_does_it(model: str, rotation: NDArray[Any]) -> None:
    new = np.array([[250.0, 0, 155], [0, 250, 120], [0, 0, 1]])
    if model == "plumb_bob":
        coefficients = PLUMB_BOB
        maps = cv2.initUndistortRectifyMap(MATRIX, coefficients, rotation, new, SIZE, cv2.CV_32FC1)
    else:
        coefficients = EQUIDISTANT
        maps = cv2.fisheye.initUndistortRectifyMap(
            MATRIX, coefficients, rotation, new, SIZE, cv2.CV_32FC1
        )
    image = smooth_image()
    expected = cv2.remap(image, *maps, cv2.INTER_LINEAR).astype(int)
    found = rectify(image, camera(model, coefficients, rotation, new)).astype(int)
    assert np.abs(found - expected).max() <= 2


def test_an_image_of_another_size_is_refused() -> None:
    with pytest.raises(
        ValueError, match="expected an image of 320x240 as in camera_info, found 4x3"
    ):
        rectify(np.zeros((3, 4), np.uint8), camera("plumb_bob", PLUMB_BOB))


def info(**changes: Any) -> CameraInfo:
    values = {
        "width": 320,
        "height": 240,
        "distortion_model": "equidistant",
        "d": [0.05, -0.02, 0.01, -3e-3],
        "k": MATRIX.ravel().tolist(),
        "r": np.eye(3).ravel().tolist(),
        "p": np.hstack([MATRIX, np.zeros((3, 1))]).ravel().tolist(),
    }
    return CameraInfo(**(values | changes))


METADATA = """{"stamp": {"sec": 1, "nanosec": 2}, "intrinsics": {"width": 320, "height": 240,
"focal_length": [300.0, 301.0], "principal_point": [160.0, 118.0],
"distortion_model": "fisheye_tangential", "distortion": [0.05, -0.02, 0.01, -3e-3, 1e-3, 0]}}"""


def test_metadata_replace_the_fitted_lens() -> None:
    assert camera_of(info(), METADATA).lens.model == "fisheye_tangential"


def test_a_calibration_with_another_k_goes_before_metadata() -> None:
    other = info(k=[299.0, 0, 160, 0, 301, 118, 0, 0, 1])
    assert camera_of(other, METADATA).lens.model == "equidistant"


def test_r_and_p_are_those_of_the_message() -> None:
    found = camera_of(info(p=[200.0, 0, 1, 7, 0, 201, 2, 0, 0, 0, 1, 0]))
    assert found.matrix == (200, 0, 1, 0, 201, 2, 0, 0, 1)


@pytest.mark.parametrize(
    "metadata",
    [
        "",
        "{",
        "[]",
        "{}",
        '{"intrinsics": null}',
        METADATA.replace("300.0", '"x"'),
        METADATA.replace("320", "1e999"),
        "[" * 100_000,
    ],
)
def test_metadata_without_intrinsics_are_refused(metadata: str) -> None:
    with pytest.raises(ValueError, match="metadata without intrinsics"):
        camera_of(info(), metadata)


@pytest.mark.parametrize(
    "change",
    [
        {"k": [0.0] * 9},
        {"p": [0.0] * 12},
        {"d": []},
        {"distortion_model": "kannala_brandt"},
        {"width": 0},
        {"binning_x": 2},
        {"r": [float("nan")] * 9},
    ],
)
def test_camera_info_without_a_calibration_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="expected"):
        camera_of(info(**change))
