"""Recordings in the files of other programs, read back by OpenCV and the csv module."""

import csv
import json
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from command_line import refusal
from ml2_receiver.cli import main
from ml2_receiver.configuration.mounts import Mount, save_mounts
from ml2_tools.geometry.pose import pose_from, quaternion_of
from sound_bag import (
    ACCELERATION,
    BEGIN_NS,
    FRAME,
    IMAGES,
    IMU,
    INFOS,
    TURN_RATE,
    Message,
    compressed,
    config,
    pixels,
    second_camera,
    sound,
    written,
)

NOISE = {
    "accelerometer_noise_density": 0.002,
    "accelerometer_random_walk": 0.0003,
    "gyroscope_noise_density": 0.0002,
    "gyroscope_random_walk": 0.00002,
}
OPTIONS = [f"--{name.replace('_', '-')}={value}" for name, value in NOISE.items()]
BASELINE_M = 0.15
MOUNT = Mount(
    (0.02, 0.07, 0.01),
    (0.5, -0.5, 0.1, -0.7),
    0.015625,
    (),
    (),
    (),
    (),
    0.0,
    "2026-01-01T00:00:00+00:00",
)


def of_recording(tmp_path: Path, messages: list[Message], *options: str) -> list[str]:
    """The words of the command that exports a recording of these."""
    bag = written(tmp_path / "bag", [config(), *messages])
    return ["export", "--euroc", str(tmp_path / "out"), "--bag", str(bag), *options]


def export(tmp_path: Path, messages: list[Message], *options: str) -> int:
    return main(of_recording(tmp_path, messages, *options))


def rows(path: Path) -> list[list[str]]:
    """Without the line of names."""
    with path.open(newline="") as file:
        return [row for row in csv.reader(file) if not row[0].startswith("#")]


def opencv(path: Path) -> Any:
    """Reads with OpenCV, as C++ programs do."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    assert storage.isOpened()
    return storage


def numbers(node: Any) -> list[float]:
    return [node.at(index).real() for index in range(node.size())]


def two_cameras() -> list[Message]:
    left = sound()
    return [*left, *second_camera(left, (1.0 + BASELINE_M, 2.0, 3.0))]


def test_a_recording_is_a_euroc_folder(tmp_path: Path) -> None:
    assert export(tmp_path, two_cameras(), "--imu", "imu_left", *OPTIONS) == 0
    root = tmp_path / "out/mav0"
    assert sorted(it.name for it in root.iterdir()) == ["cam0", "cam1", "imu0"]
    images = [it for it in sound() if it.topic == IMAGES]
    assert rows(root / "cam0/data.csv") == [
        [str(it.stamp_ns), f"{it.stamp_ns}.png"] for it in images
    ]
    for camera in ("cam0", "cam1"):
        for it in images:
            file = root / camera / "data" / f"{it.stamp_ns}.png"
            assert np.array_equal(cv2.imread(str(file), cv2.IMREAD_UNCHANGED), pixels(it))
    found = [[float(it) for it in row] for row in rows(root / "imu0/data.csv")]
    stamps = [it.stamp_ns for it in sound() if it.topic == IMU]
    assert [row[0] for row in found] == pytest.approx(stamps, rel=0, abs=256)
    assert {tuple(row[1:]) for row in found} == {(*TURN_RATE, *ACCELERATION)}


def test_images_that_the_headset_compressed_are_exported_as_opencv_decodes_them(
    tmp_path: Path,
) -> None:
    assert export(tmp_path, compressed(sound())) == 0
    images = [it for it in sound() if it.topic == IMAGES]
    files = sorted((tmp_path / "out/mav0/cam0/data").iterdir())
    assert [it.stem for it in files] == [str(it.stamp_ns) for it in images]
    for file, it in zip(files, images, strict=True):
        expected = cv2.imdecode(cv2.imencode(".jpg", pixels(it))[1], cv2.IMREAD_UNCHANGED)
        assert np.array_equal(cv2.imread(str(file), cv2.IMREAD_UNCHANGED), expected)


def test_sensor_yaml_has_lens_and_place_as_opencv_reads_them(tmp_path: Path) -> None:
    assert export(tmp_path, two_cameras()) == 0
    for number, across_m in ((0, 0.0), (1, BASELINE_M)):
        sensor = opencv(tmp_path / f"out/mav0/cam{number}/sensor.yaml")
        assert numbers(sensor.getNode("intrinsics")) == [5, 5.5, 3.5, 2.5]
        assert numbers(sensor.getNode("resolution")) == [8, 6]
        assert sensor.getNode("distortion_model").string() == "equidistant"
        assert numbers(sensor.getNode("distortion_coefficients")) == [0.1, -0.02, 3e-3, -4e-4]
        assert sensor.getNode("rate_hz").real() == 30
        place = np.array(numbers(sensor.getNode("T_BS").getNode("data"))).reshape(4, 4)
        expected = np.eye(4)
        expected[0, 3] = across_m
        assert place == pytest.approx(expected)


def test_an_imu_without_a_known_place_has_none(tmp_path: Path) -> None:
    assert export(tmp_path, sound(), "--imu", "imu_left", *OPTIONS) == 0
    sensor = opencv(tmp_path / "out/mav0/imu0/sensor.yaml")
    assert sensor.getNode("T_BS").empty()
    assert sensor.getNode("rate_hz").real() == 200
    assert {name: sensor.getNode(name).real() for name in NOISE} == pytest.approx(NOISE)


def moving_rig() -> list[Message]:
    """Two cameras and a head that move at 0.1 m/s, with poses of the head between the images."""

    def moved(it: Message) -> Message:
        x, y, z = it.position
        return replace(it, position=(x + (it.stamp_ns - BEGIN_NS) / 1e10, y, z))

    cameras = two_cameras()
    between = [
        replace(it, stamp_ns=it.stamp_ns + 5_000_000, frame="head_frame", position=(0.9, 2.2, 3.3))
        for it in cameras
        if it.topic == "/tf" and it.frame == FRAME
    ]
    return [moved(it) if it.topic == "/tf" else it for it in [*cameras, *between]]


def test_a_calibrated_imu_is_in_all_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home"))
    another = replace(MOUNT, rotation=(0.0, 0.0, 0.0, 1.0))
    save_mounts({"one": {"imu_left": MOUNT}, "two": {"imu_left": another}})
    # The cameras are at 1, 2, 3 when the head is at 0.9, 2.2, 3.3.
    place = np.eye(4)
    place[:3, :3] = Rotation.from_quat(MOUNT.rotation).as_matrix()
    place[:3, 3] = np.add(MOUNT.translation_m, (-0.1, 0.2, 0.3))
    across = np.eye(4)
    across[0, 3] = BASELINE_M

    bag = of_recording(tmp_path, moving_rig(), "--imu", "imu_left", *OPTIONS)
    assert main([*bag, "--kalibr", str(tmp_path / "kalibr")]) == 0
    kalibr = yaml.safe_load((tmp_path / "kalibr/camchain.yaml").read_text())
    unit = opencv(tmp_path / "out/mav0/imu0/sensor.yaml")
    in_body = numbers(unit.getNode("T_BS").getNode("data"))
    assert np.array(in_body).reshape(4, 4) == pytest.approx(place, abs=1e-6)
    estimator = opencv(tmp_path / "out/estimator_config.yaml")
    assert (estimator.getNode("use_stereo").string(), estimator.getNode("max_cameras").real()) == (
        "true",
        2,
    )
    chain = opencv(tmp_path / "out" / estimator.getNode("relative_config_imucam").string())
    for name, in_camera in (("cam0", place), ("cam1", np.linalg.inv(across) @ place)):
        assert np.array(kalibr[name]["T_cam_imu"]) == pytest.approx(in_camera, abs=1e-6)
        rows_of = chain.getNode(name).getNode("T_imu_cam")
        found = [numbers(rows_of.at(row)) for row in range(4)]
        assert np.array(found) == pytest.approx(np.linalg.inv(in_camera), abs=1e-6)
        found_s = chain.getNode(name).getNode("timeshift_cam_imu").real()
        assert found_s == kalibr[name]["timeshift_cam_imu"] == MOUNT.time_offset_s
    assert numbers(chain.getNode("cam0").getNode("cam_overlaps")) == [1]

    orb_slam3 = opencv(tmp_path / "out/orb_slam3.yaml")
    of_first, of_second = np.linalg.inv(place), np.linalg.inv(place) @ across
    assert orb_slam3.getNode("IMU.T_b_c1").mat() == pytest.approx(of_first, abs=1e-6)
    assert orb_slam3.getNode("Stereo.T_c1_c2").mat() == pytest.approx(across, abs=1e-6)
    assert orb_slam3.getNode("Camera2.k4").real() == pytest.approx(-4e-4)
    assert orb_slam3.getNode("IMU.Frequency").isReal()
    assert orb_slam3.getNode("IMU.GyroWalk").real() == pytest.approx(2e-5)

    vins = opencv(tmp_path / "out/vins_fusion.yaml")
    assert vins.getNode("body_T_cam0").mat() == pytest.approx(of_first, abs=1e-6)
    assert vins.getNode("body_T_cam1").mat() == pytest.approx(of_second, abs=1e-6)
    assert vins.getNode("acc_n").real() == pytest.approx(0.002 * np.sqrt(200), rel=1e-2)
    assert vins.getNode("td").real() == MOUNT.time_offset_s
    camera = opencv(tmp_path / "out" / vins.getNode("cam1_calib").string())
    assert camera.getNode("model_type").string() == "KANNALA_BRANDT"
    lens = camera.getNode("projection_parameters")
    found = [lens.getNode(it).real() for it in ("mu", "mv", "u0", "v0", "k2", "k5")]
    assert found == pytest.approx([5, 5.5, 3.5, 2.5, 0.1, -4e-4])

    basalt = json.loads((tmp_path / "out/basalt.json").read_text())["value0"]
    for pose, expected in zip(basalt["T_imu_cam"], (of_first, of_second), strict=True):
        turn = Rotation.from_quat([pose[it] for it in ("qx", "qy", "qz", "qw")])
        assert turn.as_matrix() == pytest.approx(expected[:3, :3], abs=1e-6)
        assert [pose[it] for it in ("px", "py", "pz")] == pytest.approx(expected[:3, 3], abs=1e-6)
    assert basalt["cam_time_offset_ns"] == MOUNT.time_offset_s * 1e9
    assert basalt["intrinsics"][1]["camera_type"] == "kb4"
    assert basalt["resolution"] == [[8, 6], [8, 6]]


@given(
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda it: np.hypot.reduce(it) > 0.1)
)
def test_quaternions_of_rotations_are_those_of_scipy(numbers: list[float]) -> None:
    turn = Rotation.from_quat(numbers)
    pose = np.eye(4)
    pose[:3, :3] = turn.as_matrix()
    assert (Rotation.from_quat(quaternion_of(pose)) * turn.inv()).magnitude() < 1e-7
    assert quaternion_of(pose)[3] >= 0
    assert pose_from((0, 0, 0), quaternion_of(pose)) == pytest.approx(pose, abs=1e-9)


def test_a_calibrated_imu_needs_poses_of_the_head(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home"))
    save_mounts({"one": {"imu_left": MOUNT}})
    words = of_recording(tmp_path, sound(), "--imu", "imu_left", *OPTIONS)
    assert "no head poses on /tf" in refusal(*words)


def test_orb_slam3_gets_settings_and_times(tmp_path: Path) -> None:
    """The keys are those that version 1.0 of its settings requires of a monocular fisheye."""
    assert export(tmp_path, sound()) == 0
    settings = opencv(tmp_path / "out/orb_slam3.yaml")
    assert settings.getNode("File.version").string() == "1.0"
    assert settings.getNode("Camera.type").string() == "KannalaBrandt8"
    for name, value in {"fx": 5, "fy": 5.5, "cx": 3.5, "cy": 2.5, "k1": 0.1, "k4": -4e-4}.items():
        node = settings.getNode(f"Camera1.{name}")
        assert node.isReal(), f"{name}: ORB-SLAM3 ends when a real number is written as an integer"
        assert node.real() == pytest.approx(value)
    for name in ("Camera.width", "Camera.height", "Camera.fps", "ORBextractor.nFeatures"):
        assert settings.getNode(name).isInt()
    lines = (tmp_path / "out/orb_slam3.yaml").read_text().splitlines()
    assert "Camera1.fx: 5.0" in lines, "people change these files"
    times = (tmp_path / "out/orb_slam3_times.txt").read_text().splitlines()
    images = tmp_path / "out/mav0/cam0/data"
    assert sorted(f"{it}.png" for it in times) == sorted(it.name for it in images.iterdir())


def test_open_vins_gets_an_estimator_and_an_imu(tmp_path: Path) -> None:
    assert export(tmp_path, sound(), "--imu", "imu_left", *OPTIONS) == 0
    estimator = opencv(tmp_path / "out/estimator_config.yaml")
    assert estimator.getNode("max_cameras").real() == 1
    # VioManagerOptions::print_and_load_estimator() and _noise() fail without them
    zero_velocity = ("chi2_multipler", "max_velocity", "noise_multiplier", "max_disparity")
    for name in (*zero_velocity, "only_at_beginning"):
        assert not estimator.getNode(f"zupt_{name}").empty(), name
    chain = tmp_path / "out" / estimator.getNode("relative_config_imu").string()
    storage = opencv(chain)
    unit = storage.getNode("imu0")
    assert unit.getNode("rostopic").string() == IMU
    assert {name: unit.getNode(name).real() for name in NOISE} == pytest.approx(NOISE)
    assert numbers(unit.getNode("T_i_b").at(3)) == [0, 0, 0, 1]


def test_kalibr_yaml_names_the_image_topic_that_was_recorded(tmp_path: Path) -> None:
    left = compressed(sound())
    bag = written(tmp_path / "bag", [config(), *left, *second_camera(sound(), (2.0, 2.0, 3.0))])
    assert main(["export", "--kalibr", str(tmp_path / "out"), "--bag", str(bag)]) == 0
    chain = yaml.safe_load((tmp_path / "out/camchain.yaml").read_text())
    assert chain["cam0"]["rostopic"] == f"{IMAGES}/compressed"
    assert chain["cam1"]["rostopic"] == IMAGES.replace("left", "right")


def test_kalibr_yaml_comes_from_a_recording_too(tmp_path: Path) -> None:
    bag = written(tmp_path / "bag", [config(), *two_cameras()])
    out = tmp_path / "out"
    options = ["--kalibr", str(out), "--bag", str(bag), "--imu", "imu_left", *OPTIONS]
    assert main(["export", *options, "--cameras", "world_right", "world_left"]) == 0
    chain = yaml.safe_load((out / "camchain.yaml").read_text())
    assert chain["cam0"]["rostopic"] == IMAGES.replace("left", "right")
    from_right = np.array(chain["cam1"]["T_cn_cnm1"]) @ [0, 0, 0, 1]
    assert from_right == pytest.approx([BASELINE_M, 0, 0, 1])
    assert yaml.safe_load((out / "imu.yaml").read_text())["update_rate"] == pytest.approx(200)


def test_a_recorded_rig_is_joined_of_all_static_transforms(tmp_path: Path) -> None:
    """Three nodes say one transform each; the last is none of the headset's."""
    places = [("head_frame", FRAME, 0.0), ("base_link", "lidar", 9.0)]
    places.insert(1, ("head_frame", FRAME.replace("left", "right"), BASELINE_M))
    (some, *_) = (it for it in sound() if it.topic == "/tf")
    static = [
        replace(some, topic="/tf_static", parent=parent, frame=frame, position=(x, 0.0, 0.0))
        for parent, frame, x in places
    ]
    rig = [replace(it, frame="head_frame") for it in sound() if it.topic == "/tf"]
    others = [it for it in two_cameras() if it.topic != "/tf"]
    bag = written(tmp_path / "bag", [config(), *static, *rig, *others])
    assert main(["export", "--kalibr", str(tmp_path / "out"), "--bag", str(bag)]) == 0
    chain = yaml.safe_load((tmp_path / "out/camchain.yaml").read_text())
    right_of_left = np.array(chain["cam1"]["T_cn_cnm1"]) @ [0, 0, 0, 1]
    assert right_of_left == pytest.approx([-BASELINE_M, 0, 0, 1])


def broken(topic: str, payload: bytes) -> Callable[[Message], Message]:
    return lambda it: replace(it, payload=payload) if it.topic == topic else it


IMAGE_HEAD = struct.pack("<4sIII", b"\0\1\0\0", 1, 5, 1) + b"\0\0\0\0"


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (broken(IMAGES, b""), f"{IMAGES}: not a sensor_msgs/msg/Image"),
        (broken(IMAGES, IMAGE_HEAD + struct.pack("<II", 1 << 31, 1 << 31)), f"{IMAGES}: not a"),
        (broken(INFOS, b"\0\1\0\0"), f"{INFOS}: not a sensor_msgs/msg/CameraInfo"),
        (broken("/tf", b"\0\1\0\0\xff\xff\xff\xff"), "/tf: not a tf2_msgs/msg/TFMessage"),
        (lambda it: replace(it, stamp_ns=BEGIN_NS) if it.topic == IMAGES else it, "comes after"),
    ],
)
def test_what_cannot_be_exported_is_said_in_one_line(
    tmp_path: Path, damage: Callable[[Message], Message], words: str
) -> None:
    said = refusal(*of_recording(tmp_path, [damage(it) for it in sound()]))
    assert words in said.strip().splitlines()[-1]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "expected --kalibr, --euroc or --tum FOLDER, found none"),
        (["--euroc", "x"], "--euroc needs a recording: name it with --bag"),
        (["--euroc", "x", "--bag", "/dev/null/nowhere"], "cannot read /dev/null/nowhere"),
    ],
)
def test_options_that_do_not_belong_together_are_refused(options: list[str], words: str) -> None:
    assert words in refusal("export", *options)


def test_what_is_there_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "out/mav0").mkdir(parents=True)
    assert "mav0 exists already" in refusal(*of_recording(tmp_path, sound()))
    assert list((tmp_path / "out/mav0").iterdir()) == []


def test_cameras_that_are_missing_are_named(tmp_path: Path) -> None:
    command = of_recording(tmp_path, sound(), "--cameras", "world_left", "color")
    assert "no camera_info of color is in the recording" in refusal(*command)
