"""Calibrates the simulated headset's inertial units from its walk, and reads /tf_static."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bags import message_counts
from configurations import only
from ml2_receiver.configuration.mounts import load_mounts
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.bags.decoding import decoder
from processes import PREFIX, RECEIVER, ended, recorded_walk
from simulated_scene import TO_ROS
from simulated_truth import SimulatedTruth
from simulation import EXACT

_POSES = 26 * 60  # what calibrate wants at least, and some gaps


def test_a_walk_shows_the_mounts_and_run_publishes_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home"))
    config = tmp_path / "config.yaml"
    config.write_text(only("head_pose: {enabled: true}, other_sensors: {enabled: true}"))
    before, after = tmp_path / "before", tmp_path / "after"
    before.mkdir()
    after.mkdir()
    walk = recorded_walk(
        config, before, lambda it: message_counts(it).get(f"{PREFIX}/head_pose", 0) > _POSES, *EXACT
    )
    calibrate: list[str | Path] = [RECEIVER, "calibrate", "imu", "--bag", walk]
    ended(calibrate).check_returncode()

    true = json.loads(SimulatedTruth.now().library.ml2sim_mounts())
    ((_, mounts),) = load_mounts().items()
    for unit in ("imu_left", "imu_right"):
        assert mounts[unit].translation_m == pytest.approx(
            TO_ROS @ np.array(true[unit]["position"]), abs=5e-4
        )
        turned = Rotation.from_matrix(TO_ROS) * Rotation.from_quat(true[unit]["rotation"])
        off = (Rotation.from_quat(mounts[unit].rotation) * turned.inv()).magnitude()
        assert np.degrees(off) < 0.1
        assert abs(mounts[unit].time_offset_s) < 0.2e-3

    again = recorded_walk(config, after, lambda it: message_counts(it).get("/tf_static", 0) > 0)
    (data,) = (it.payload for it in BagReader(again).messages() if it.topic == "/tf_static")
    published = {it.child_frame_id: it for it in decoder("tf2_msgs/msg/TFMessage")(data).transforms}
    assert set(published) == {"imu_left_frame", "imu_right_frame"}
    for unit in ("imu_left", "imu_right"):
        place = published[f"{unit}_frame"].transform.translation
        assert published[f"{unit}_frame"].header.frame_id == "head_frame"
        assert (place.x, place.y, place.z) == pytest.approx(mounts[unit].translation_m)
