"""`ml2-receiver export` while a simulated headset streams."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from capture_stamps import stamp_ns
from configurations import only
from other_programs import collect, streaming
from processes import PREFIX, RECEIVER, ended
from transforms import transforms
from waiting import await_true

CONFIG = only(
    """
    world_left: {enabled: true},
    world_right: {enabled: true, calibration: right.yaml},
    picture_center: {enabled: true, resolution_width: 1280, resolution_height: 960},
    imu: {united: true},
    """
)
CALIBRATION = """
image_width: 1016
image_height: 1016
camera_name: right
camera_matrix: {rows: 3, cols: 3, data: [555, 0, 501, 0, 556, 502, 0, 0, 1]}
distortion_model: equidistant
distortion_coefficients: {rows: 1, cols: 4, data: [0.25, 0, 0, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [555, 0, 501, 0, 0, 556, 502, 0, 0, 0, 1, 0]}
"""
NOISE = {
    "accelerometer_noise_density": 0.002,
    "accelerometer_random_walk": 0.0003,
    "gyroscope_noise_density": 0.0002,
    "gyroscope_random_walk": 0.00002,
}


def test_the_rig_in_kalibr_yaml_is_the_one_in_the_transform_tree(tmp_path: Path) -> None:
    config, out = tmp_path / "config.yaml", tmp_path / "out"
    config.write_text(CONFIG)
    (tmp_path / "right.yaml").write_text(CALIBRATION)
    options = [f"--{name.replace('_', '-')}={value}" for name, value in NOISE.items()]
    export: list[str | Path] = [RECEIVER, "export", "--kalibr", out, "--imu", "imu_left", *options]
    with streaming(config, tmp_path, still_images="1") as domain:
        topics = {"/tf": "tf2_msgs/msg/TFMessage"} | dict.fromkeys(
            ("world_left/camera_info", "color/camera_info"), "sensor_msgs/msg/CameraInfo"
        )
        received = collect(topics, 10, domain, tmp_path)

        def exported() -> bool:
            """On a slow machine, what it needs may not come while it waits for it."""
            return "T_cam_imu is not in camchain.yaml" in ended(export, domain).stdout

        await_true(exported)
    chain = yaml.safe_load((out / "camchain.yaml").read_text())
    assert {name: cam["rostopic"] for name, cam in chain.items()} == {
        "cam0": f"{PREFIX}/world_left/image_raw",
        "cam1": f"{PREFIX}/world_right/image_raw",
        "cam2": f"{PREFIX}/color/image_raw/compressed",
    }
    info = received.messages("world_left/camera_info")[0]
    assert chain["cam0"]["intrinsics"] == [info.k[0], info.k[4], info.k[2], info.k[5]]
    assert chain["cam0"]["distortion_coeffs"] == list(info.d)
    assert chain["cam1"]["intrinsics"] == [555, 556, 501, 502], "the user's calibration"
    assert chain["cam1"]["distortion_coeffs"] == [0.25, 0, 0, 0]
    assert (chain["cam2"]["resolution"], chain["cam2"]["distortion_model"]) == (
        [1280, 960],
        "radtan",
    )
    tree = transforms(received)
    stamps = {stamp_ns(it) for it in received.messages("world_left/camera_info")}
    together = [
        np.linalg.inv(tree["world_right_optical_frame", at]) @ pose
        for (frame, at), pose in tree.items()
        if frame == "world_left_optical_frame"
        and at in stamps
        and ("world_right_optical_frame", at) in tree
    ]
    assert together, "the world cameras are exposed together"
    assert chain["cam1"]["T_cn_cnm1"] == pytest.approx(together[0], abs=1e-3)
    imu = yaml.safe_load((out / "imu.yaml").read_text())
    assert imu == NOISE | {"rostopic": f"{PREFIX}/imu_left/imu", "update_rate": imu["update_rate"]}
    assert imu["update_rate"] == pytest.approx(200, rel=0.1)
