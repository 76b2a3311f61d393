import os
import pty
from pathlib import Path

import pytest

from configurations import calibration_yaml
from ml2_receiver.configuration.calibration import load_calibration
from ml2_receiver.configuration.config import load_config
from ml2_receiver.errors import CalibrationError, ConfigError

CONFIG = """/ml2_receiver:
  ros__parameters:
    world_left: {enabled: true, calibration: left.yaml}
    depth_center: {enabled: true}
"""


def test_a_file_of_camera_calibration_is_read(tmp_path: Path) -> None:
    file = tmp_path / "left.yaml"
    file.write_text(calibration_yaml())
    found = load_calibration(file)
    assert (found.width, found.height, found.model) == (1016, 1016, "equidistant")
    assert found.d == (0.1, -0.02, 3e-3, -4e-4)
    assert found.k == (580.5, 0, 507, 0, 581, 508, 0, 0, 1)
    assert found.r == (1, 0, 0, 0, 1, 0, 0, 0, 1)
    assert found.p == (400, 0, 500, 0, 0, 401, 501, 0, 0, 0, 1, 0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected a mapping"),
        ("- 1", "expected a mapping"),
        ("{", "expected"),
        ("[" * 10_000, "recursion"),
        ("x: " + "y" * 70_000, "expected at most 65536 bytes"),
        (calibration_yaml(image_width=None), "image_width is missing"),
        (calibration_yaml(image_width="wide"), "image_width: expected pixels, found wide"),
        (calibration_yaml(image_height=0), "image_height: expected pixels, found 0"),
        (calibration_yaml(image_width=True), "image_width: expected pixels, found True"),
        (
            calibration_yaml(distortion_model="kannala_brandt"),
            "distortion_model: expected one of plumb_bob, rational_polynomial, equidistant, found",
        ),
        (calibration_yaml(distortion_model=[1]), "unhashable"),
        (
            calibration_yaml(distortion_model="plumb_bob"),
            "distortion_coefficients: expected 1x5 numbers, found 1x4 with 4",
        ),
        (calibration_yaml(camera_matrix=5), "camera_matrix: expected rows, cols and data"),
        (calibration_yaml(camera_matrix={"rows": 3, "cols": 3}), "data is missing"),
        (
            calibration_yaml(camera_matrix={"rows": 3, "cols": 3, "data": [0] * 9}),
            "camera_matrix: expected focal lengths above 0",
        ),
        (
            calibration_yaml(camera_matrix={"rows": 3, "cols": 3, "data": [float("nan")] * 9}),
            "camera_matrix: expected finite numbers",
        ),
        (
            calibration_yaml(camera_matrix={"rows": 3, "cols": 3, "data": ["a"] * 9}),
            "could not convert",
        ),
    ],
)
def test_what_is_no_calibration_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "left.yaml"
    file.write_text(text)
    with pytest.raises(CalibrationError, match=f"left.yaml.*{message}"):
        load_calibration(file)


def test_aliases_are_refused_and_messages_are_short(tmp_path: Path) -> None:
    """Nine levels of nine references each stand for 400 million numbers."""
    levels = [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 9)]
    bomb, text = tmp_path / "bomb.yaml", tmp_path / "text.yaml"
    bomb.write_text("\n".join(["a0: &a0 [1]", *levels, "camera_matrix: *a8"]))
    text.write_text(calibration_yaml(camera_matrix=["x" * 30_000]))
    for file, said in ((bomb, "found an alias"), (text, "expected rows, cols and data")):
        with pytest.raises(CalibrationError, match=said) as refused:
            load_calibration(file)
        assert len(str(refused.value)) <= 2000


def test_what_is_no_regular_file_is_refused_at_once(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    terminal, other = pty.openpty()
    for path in (pipe, Path(os.ttyname(other)), Path("/dev/zero")):
        with pytest.raises(CalibrationError, match="expected a regular file"):
            load_calibration(path)
    os.close(terminal)
    os.close(other)


def test_what_is_refused_is_closed(tmp_path: Path) -> None:
    opened = len(list(Path("/proc/self/fd").iterdir()))
    for path in (tmp_path, Path("/dev/zero")):
        with pytest.raises(CalibrationError, match="expected a regular file"):
            load_calibration(path)
    assert len(list(Path("/proc/self/fd").iterdir())) == opened


def test_the_configuration_names_a_file_beside_itself(tmp_path: Path) -> None:
    (tmp_path / "left.yaml").write_text(calibration_yaml())
    (tmp_path / "config.yaml").write_text(CONFIG)
    config = load_config(tmp_path / "config.yaml")
    assert set(config.calibrations) == {"world_left"}
    assert config.calibrations["world_left"].k[0] == 580.5
    assert "calibration" not in config.requests["world_left"], "it stays on this side"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("missing.yaml", r"config.yaml:3: world_left.calibration: .*missing.yaml cannot be read"),
        ("half.yaml", "expected a calibration for 1016x1016, found 508x1016"),
        (
            '"~nosuchuser/left.yaml"',
            r"config.yaml:3: world_left.calibration: ~nosuchuser/left.yaml: .*home",
        ),
    ],
)
def test_a_calibration_that_cannot_be_used_is_a_wrong_value(
    tmp_path: Path, name: str, message: str
) -> None:
    (tmp_path / "half.yaml").write_text(calibration_yaml(image_width=508))
    (tmp_path / "config.yaml").write_text(CONFIG.replace("left.yaml", name))
    with pytest.raises(ConfigError, match=message):
        load_config(tmp_path / "config.yaml")
