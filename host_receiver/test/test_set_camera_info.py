"""Calibrations that are set while the receiver runs, as camera_calibration does."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo

from configurations import DOCUMENT, calibration_yaml, only
from ml2_receiver.configuration.config import load_config
from mock_device import MockDevice
from ros_messages import TYPES
from ros_processes import Client, Subscriber

CONFIG = only(
    """
    world_left: {enabled: true},
    world_right: {enabled: true, calibration: right.yaml},
    picture_center: {enabled: true}
    """
)
TYPE = "sensor_msgs/msg/CameraInfo"
LEFT, RIGHT = "/magic_leap2/world_left", "/magic_leap2/world_right"
INFO: dict[str, Any] = {
    "width": 1016,
    "height": 1016,
    "distortion_model": "plumb_bob",
    "d": [0.1, -0.2, 0.003, -0.004, 0.05],
    "k": [600.0, 0.0, 508.0, 0.0, 601.0, 509.0, 0.0, 0.0, 1.0],
    "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    "p": [500.0, 0.0, 500.0, 0.0, 0.0, 501.0, 501.0, 0.0, 0.0, 0.0, 1.0, 0.0],
}
FILE_K = yaml.safe_load(calibration_yaml())["camera_matrix"]["data"]
OWN = bytes(serialize_message(CameraInfo(width=1016, height=1016, distortion_model="plumb_bob")))
REFUSED: list[tuple[str, dict[str, Any], str]] = [
    (LEFT, {"width": 508}, "expected a calibration for 1016x1016, found 508x1016"),
    (LEFT, {"distortion_model": "fisheye"}, "distortion_model: expected one of plumb_bob, "),
    (LEFT, {"d": [0.1] * 4}, "distortion_coefficients: expected 1x5 numbers, found 1x4"),
    (LEFT, {"k": [0.0] * 9}, "camera_matrix: expected focal lengths above 0, found 0.0"),
    (LEFT, {"p": [0.0] * 12}, "projection_matrix: expected focal lengths above 0"),
    (LEFT, {"r": [float("nan")] * 9}, "rectification_matrix: expected finite numbers"),
    ("/magic_leap2/mixed_reality", {}, "mixed_reality is not enabled"),
    ("/magic_leap2/color", {}, "expected a calibration for 1920x1080, found 1016x1016"),
]


@pytest.fixture
def config(tmp_path: Path) -> Path:
    (tmp_path / "right.yaml").write_text(calibration_yaml())
    file = tmp_path / "config.yaml"
    file.write_text(CONFIG)
    return file


def seen(device: MockDevice, camera: str) -> Any:
    """The next camera_info of the device's, as a subscriber gets it."""
    with Subscriber(f"{camera}/camera_info", TYPE) as subscriber:
        while not subscriber.has_line(0.1):
            device.publish(f"{camera.rpartition('/')[2]}/camera_info", OWN)
        device.publish(f"{camera.rpartition('/')[2]}/camera_info", OWN)
        return TYPES.deserialize_cdr(subscriber.message(), TYPE)


def test_it_counts_from_the_next_message_on_and_survives_other_changes(
    client: Client, device: MockDevice, config: Path
) -> None:
    assert list(seen(device, LEFT).k) == [0] * 9
    is_set, said = client.ask("calibrate", LEFT, INFO)
    assert is_set
    assert "until the receiver ends; " in said
    assert f"name that in {config} as world_left.calibration" in said
    client.ask("enable", "battery", True)
    client.ask("set", {"world_left.stream": 1})
    info = seen(device, LEFT)
    assert {key: getattr(info, key) for key in ("width", "height", "distortion_model")} == {
        key: INFO[key] for key in ("width", "height", "distortion_model")
    }
    assert {key: list(getattr(info, key)) for key in "dkrp"} == {key: INFO[key] for key in "dkrp"}
    assert client.ask("trigger", "reload") == [True, ""]
    assert list(seen(device, LEFT).k) == [0] * 9, "the file has none"


def test_it_is_written_to_the_file_that_is_configured(
    client: Client, device: MockDevice, config: Path
) -> None:
    file = config.with_name("right.yaml")
    assert list(seen(device, RIGHT).k) == FILE_K
    assert client.ask("calibrate", RIGHT, INFO) == [True, f"applied, and written to {file}"]
    assert list(seen(device, RIGHT).k) == INFO["k"]
    written = yaml.safe_load(file.read_text())
    assert list(written) == list(DOCUMENT)
    assert written["camera_name"] == "world_right"
    assert written["projection_matrix"] == {"rows": 3, "cols": 4, "data": INFO["p"]}
    assert load_config(config).calibrations["world_right"].d == tuple(INFO["d"])


def test_what_is_no_calibration_is_refused_and_changes_nothing(
    client: Client,
) -> None:
    for camera, changes, reason in REFUSED:
        is_set, said = client.ask("calibrate", camera, {**INFO, **changes})
        assert (is_set, reason in said) == (False, True), (camera, changes, said)


def test_a_file_that_cannot_be_written_leaves_the_calibration_as_it_was(
    client: Client, device: MockDevice, config: Path
) -> None:
    file = config.with_name("right.yaml")
    file.chmod(0o444)
    is_set, said = client.ask("calibrate", RIGHT, INFO)
    assert (is_set, said) == (False, f"{file} cannot be written: it is read-only")
    assert list(seen(device, RIGHT).k) == FILE_K
