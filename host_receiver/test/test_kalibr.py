"""Kalibr YAML, by OpenCV and geometry."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from command_line import refusal
from ml2_receiver.configuration.calibration import Calibration
from ml2_tools.errors import ExportError
from ml2_tools.export.kalibr import ImuNoise, RigCamera, camchain, imu
from ml2_tools.export.rig import rate_hz

MATRIX = np.array([[900.0, 0, 640], [0, 901, 480], [0, 0, 1]])
EQUIDISTANT = (0.1, -0.02, 3e-3, -4e-4)


def camera(model: str, d: tuple[float, ...], pose: Any = np.eye(4)) -> RigCamera:  # noqa: B008
    k = tuple(MATRIX.ravel().tolist())
    return RigCamera("/images", Calibration(1280, 960, model, d, k, (), ()), pose)


def test_cameras_have_the_keys_of_kalibr() -> None:
    chain = yaml.safe_load(camchain([camera("equidistant", EQUIDISTANT)]))
    assert chain == {
        "cam0": {
            "camera_model": "pinhole",
            "intrinsics": [900, 901, 640, 480],
            "distortion_model": "equidistant",
            "distortion_coeffs": list(EQUIDISTANT),
            "resolution": [1280, 960],
            "rostopic": "/images",
        }
    }


def test_each_camera_takes_points_from_the_one_before() -> None:
    """The second looks back along the first's x axis, 0.2 m to its right."""
    second = np.array([[0, 0, -1, 0.2], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
    somewhere = np.eye(4)
    somewhere[:3] = np.hstack([cv2.Rodrigues(np.array([0.3, 0.2, 0.1]))[0], [[1], [2], [3]]])
    rig = [camera("equidistant", EQUIDISTANT, pose) for pose in (somewhere, somewhere @ second)]
    chain = yaml.safe_load(camchain(rig))
    assert "T_cn_cnm1" not in chain["cam0"]
    origin_of_first = np.array(chain["cam1"]["T_cn_cnm1"]) @ [0, 0, 0, 1]
    assert origin_of_first == pytest.approx([0, 0, 0.2, 1])


def test_plumb_bob_without_k3_is_radtan() -> None:
    text = camchain([camera("plumb_bob", (0.1, -0.05, 1e-3, 2e-3, 0))])
    assert yaml.safe_load(text)["cam0"]["distortion_coeffs"] == [0.1, -0.05, 1e-3, 2e-3]
    assert "#" not in text


def test_k3_is_fitted_and_what_remains_is_said() -> None:
    d = (0.1, -0.2, 1e-3, -2e-3, 0.15)
    text = camchain([camera("plumb_bob", d)])
    cam = yaml.safe_load(text)["cam0"]
    said_px = float(text.split(" off by ")[1].split()[0])
    columns, rows = np.meshgrid(np.linspace(0, 1279, 40), np.linspace(0, 959, 30))
    pixels = np.stack([columns, rows], -1).reshape(-1, 1, 2)
    rays = cv2.undistortPoints(pixels, MATRIX, np.array(d)).reshape(-1, 2)
    points = np.hstack([rays, np.ones((len(rays), 1))])
    exact, fitted, cut = (
        cv2.projectPoints(points, np.zeros(3), np.zeros(3), MATRIX, np.array(it))[0].reshape(-1, 2)
        for it in (d, cam["distortion_coeffs"], d[:4])
    )
    missed_px = np.linalg.norm(fitted - exact, axis=1).max()
    assert missed_px == pytest.approx(said_px, rel=0.2)
    assert missed_px < np.linalg.norm(cut - exact, axis=1).max() / 5


@pytest.mark.parametrize(
    ("model", "d"), [("rational_polynomial", (0.0,) * 8), ("plumb_bob", ()), ("", ())]
)
def test_a_lens_that_kalibr_has_no_model_for_is_refused(model: str, d: tuple[float, ...]) -> None:
    with pytest.raises(ExportError, match="expected a lens that Kalibr has a model for"):
        camchain([camera(model, d)])


@pytest.mark.parametrize("lost", [(), (7, 30, 31, 32, 90)])
def test_the_rate_of_an_imu_is_that_at_which_it_measures(lost: tuple[int, ...]) -> None:
    """By a clock of whole milliseconds, each 2.4 ms, so that periods are 2 and 3 ms."""
    stamps_ns = {it * 12 // 5 * 1_000_000 for it in range(101) if it not in lost}
    assert rate_hz(stamps_ns) == pytest.approx(1000 / 2.4, rel=0.02)


def test_one_reading_has_no_rate() -> None:
    assert rate_hz({5}) is None


def test_an_imu_has_the_keys_of_kalibr() -> None:
    assert yaml.safe_load(imu("/imu", 199.987, ImuNoise(1e-3, 2e-3, 3e-3, 4e-3))) == {
        "rostopic": "/imu",
        "update_rate": 199.99,
        "accelerometer_noise_density": 1e-3,
        "accelerometer_random_walk": 2e-3,
        "gyroscope_noise_density": 3e-3,
        "gyroscope_random_walk": 4e-3,
    }


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--imu", "imu_left"], "expected --accelerometer-noise-density with --imu, above 0"),
        (["--gyroscope-random-walk", "1"], "--gyroscope-random-walk needs an IMU"),
        (["--imu", "imu_left", "--accelerometer-noise-density", "nan"], "found nan"),
    ],
)
def test_noise_is_never_made_up(tmp_path: Path, options: list[str], message: str) -> None:
    assert message in refusal("export", "--kalibr", tmp_path, *options)
