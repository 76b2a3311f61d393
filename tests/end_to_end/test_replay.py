"""A replayed EuRoC data set arrives unchanged at an independent rclpy subscriber.

One that this makes is replayed in any clone, a recorded one where it lies beside the clone.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from capture_stamps import stamp_ns
from euroc import Matrix, angle_between, ground_truth, interpolated, rows, sensor_yaml
from made_recording import write_recording
from processes import EXCERPT, PREFIX, Received, headset_command, receive
from simulation import compressed_config, raw_config
from transforms import transforms

CAMERAS = {"cam0": "world_left", "cam1": "world_right"}
SENSORS = {"head_pose": "state_groundtruth_estimate0"}
SENSORS |= {f"{imu}/imu": "imu0" for imu in ("accel_left", "gyro_left", "imu_left")}
for camera, stream in CAMERAS.items():
    SENSORS |= {f"{stream}/{topic}": camera for topic in ("image_raw", "camera_info", "metadata")}
COMPRESSED = "world_left/image_raw/compressed"
# No subscriber is as fast as full speed, nor as any where it stands still for a moment.
DEEP_PUBLISHERS = ["--ros-args"]
for name in ("/tf", *(f"{PREFIX}/{topic}" for topic in (*SENSORS, COMPRESSED))):
    DEEP_PUBLISHERS += ["-p", f"qos_overrides.{name}.publisher.depth:=1000"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module", params=["2", "max"])
def rate_factor(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def recording(rate_factor: str, made: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """At full speed the made one with every fifth row of ground truth, to test interpolation."""
    if rate_factor != "max":
        return EXCERPT if EXCERPT.is_dir() else made
    folder = tmp_path_factory.mktemp("recording")
    truth = folder / "mav0" / "state_groundtruth_estimate0"
    truth.mkdir(parents=True)
    for sensor in (*CAMERAS, "imu0"):
        (truth.parent / sensor).symlink_to(made / "mav0" / sensor)
    head, *lines = (made / "mav0" / truth.name / "data.csv").read_text().splitlines(keepends=True)
    (truth / "data.csv").write_text("".join([head, *lines[::5]]))
    return folder


@pytest.fixture(scope="module")
def replayed(
    rate_factor: str, recording: Path, tmp_path_factory: pytest.TempPathFactory
) -> Received:
    headset = ["--replay", str(recording), "--rate-factor", rate_factor]
    folder = tmp_path_factory.mktemp("replay")
    config = folder / "config.yaml"
    config.write_text(raw_config())
    return receive(config, headset, folder, receiver_options=DEEP_PUBLISHERS)


@pytest.fixture(scope="module")
def shift_ns(replayed: Received, recording: Path) -> int:
    """The ROS time of the first image minus its recorded time."""
    return stamp_ns(replayed.messages("world_left/image_raw")[0]) - int(
        rows(recording, "cam0")[0][0]
    )


@pytest.mark.parametrize("camera", CAMERAS)
def test_every_image_has_the_pixels_of_its_png(
    replayed: Received, recording: Path, camera: str
) -> None:
    images = replayed.messages(f"{CAMERAS[camera]}/image_raw")
    names = [name for _, name in rows(recording, camera)]
    assert len(images) == len(names) > 0
    for image, name in zip(images, names, strict=True):
        png = cv2.imread(str(recording / "mav0" / camera / "data" / name), cv2.IMREAD_UNCHANGED)
        assert png is not None
        assert (image.encoding, image.height, image.width) == ("mono8", *png.shape)
        assert image.step == image.width
        assert bytes(image.data) == png.tobytes()
        assert image.header.frame_id == f"{CAMERAS[camera]}_optical_frame"


def test_a_recording_can_be_sent_compressed(made: Path, tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(compressed_config())
    headset = ["--replay", str(made), "--rate-factor", "max"]
    received = receive(config, headset, tmp_path, receiver_options=DEEP_PUBLISHERS)
    images = received.messages(COMPRESSED)
    names = [name for _, name in rows(made, "cam0")]
    assert len(images) == len(names) > 0
    for image, name in zip(images, names, strict=True):
        decoded = cv2.imdecode(np.frombuffer(image.data, np.uint8), cv2.IMREAD_UNCHANGED)
        png = cv2.imread(str(made / "mav0" / "cam0" / "data" / name), cv2.IMREAD_UNCHANGED)
        assert decoded is not None
        assert png is not None
        assert cv2.PSNR(decoded, png) > 35


@pytest.mark.parametrize("topic", SENSORS)
def test_stamps_are_the_recorded_ones_plus_one_constant(
    replayed: Received, recording: Path, shift_ns: int, topic: str
) -> None:
    recorded = [int(row[0]) for row in rows(recording, SENSORS[topic])]
    pairs = zip(replayed.messages(topic), recorded, strict=True)
    assert {stamp_ns(message) - at for message, at in pairs} == {shift_ns}


def test_every_imu_sample_has_the_recorded_values(replayed: Received, recording: Path) -> None:
    recorded = [[float(value) for value in row[1:]] for row in rows(recording, "imu0")]
    assert recorded

    def vector(v: Any) -> list[float]:
        return [v.x, v.y, v.z]

    gyro = [vector(m.angular_velocity) for m in replayed.messages("gyro_left/imu")]
    accel = [vector(m.linear_acceleration) for m in replayed.messages("accel_left/imu")]
    assert gyro == [row[:3] for row in recorded]
    assert accel == [row[3:] for row in recorded]
    united = replayed.messages("imu_left/imu")
    both = [vector(m.angular_velocity) + vector(m.linear_acceleration) for m in united]
    assert both == recorded
    for message in (*replayed.messages("gyro_left/imu"), *united):
        assert message.header.frame_id == "imu_left_frame"
        assert message.orientation_covariance[0] == -1
    assert {m.linear_acceleration_covariance[0] for m in replayed.messages("gyro_left/imu")} == {-1}
    assert {m.angular_velocity_covariance[0] for m in replayed.messages("accel_left/imu")} == {-1}


@pytest.mark.parametrize("camera", CAMERAS)
def test_calibration_comes_from_the_recording(
    replayed: Received, recording: Path, camera: str
) -> None:
    calibration = sensor_yaml(recording, camera)
    fx, fy, cx, cy = calibration["intrinsics"]
    for info in replayed.messages(f"{CAMERAS[camera]}/camera_info"):
        assert info.distortion_model == "plumb_bob"
        assert list(info.d) == [*calibration["distortion_coefficients"], 0.0]
        assert list(info.k) == [fx, 0, cx, 0, fy, cy, 0, 0, 1]
        assert list(info.r) == [1, 0, 0, 0, 1, 0, 0, 0, 1]
        assert list(info.p) == [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0]
        assert [info.width, info.height] == calibration["resolution"]


def assert_same_pose(found: Matrix, expected: Matrix) -> None:
    assert np.linalg.norm(found[:3, 3] - expected[:3, 3]) < 1e-6
    assert angle_between(found, expected) < 1e-6


def test_the_head_is_the_ground_truth(replayed: Received, recording: Path, shift_ns: int) -> None:
    found, truth = transforms(replayed), ground_truth(recording)
    heads = {
        stamp - shift_ns: pose for (child, stamp), pose in found.items() if child == "head_frame"
    }
    assert heads.keys() == truth.keys()
    for stamp, expected in truth.items():
        assert_same_pose(heads[stamp], expected)


@pytest.mark.parametrize("camera", CAMERAS)
def test_cameras_are_where_ground_truth_and_extrinsics_put_them(
    replayed: Received, recording: Path, shift_ns: int, camera: str
) -> None:
    found, truth = transforms(replayed), ground_truth(recording)
    mounting = np.array(sensor_yaml(recording, camera)["T_BS"]["data"]).reshape(4, 4)
    recorded = [int(row[0]) for row in rows(recording, camera)]
    covered = [at for at in recorded if min(truth) <= at <= max(truth)]
    optical = f"{CAMERAS[camera]}_optical_frame"
    assert {stamp - shift_ns for child, stamp in found if child == optical} == set(covered)
    for at in covered:
        camera_pose = found[optical, at + shift_ns]
        assert_same_pose(camera_pose, interpolated(truth, at) @ mounting)
        body = found[f"{CAMERAS[camera]}_frame", at + shift_ns]
        # REP-103: optical z is the body's x, optical x its -y, optical y its -z
        axes = np.stack([camera_pose[:3, 2], -camera_pose[:3, 0], -camera_pose[:3, 1]], axis=1)
        assert np.allclose(body[:3, :3], axes, atol=1e-9)


def test_every_stream_has_an_answer(replayed: Received) -> None:
    streams = replayed.snapshot["streams"]
    assert all(streams[stream]["result"] == "adjusted" for stream in CAMERAS.values())
    assert streams["world_left"]["values"]["resolution_width"] == 752
    assert streams["world_left"]["values"]["update_rate"] == 20
    assert streams["gyro_left"]["result"] == "applied"
    refused = {name for name, answer in streams.items() if answer["result"] == "refused"}
    assert {"color", "depth", "eye_nasal_left", "gyro_right", "battery"} <= refused
    assert {streams[name]["reason"] for name in refused} == {"not in this recording"}


def test_nothing_is_lost(replayed: Received) -> None:
    for topic, seen in replayed.snapshot["topics"].items():
        assert seen["count"] == int(replayed.counters(topic)["produced"]), topic


def test_a_missing_recording_is_an_error(tmp_path: Path) -> None:
    command = headset_command("127.0.0.1:1", "--replay", str(tmp_path))
    run = subprocess.run(command, check=False, capture_output=True, text=True)
    assert run.returncode == 2
    assert str(tmp_path) in run.stderr
