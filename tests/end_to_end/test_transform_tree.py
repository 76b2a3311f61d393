"""The layouts of the transform tree, and what becomes of it while the head is not tracked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from euroc import angle_between, pose_matrix
from processes import Received, receive
from room import TO_ROS
from simulated_truth import OPTICAL, SimulatedTruth
from simulation import CAMERAS, demo_config, image_topic
from transforms import moving, standing


def received_with(folder: Path, tf: dict[str, Any], *options: str) -> Received:
    config = folder / "config.yaml"
    config.write_text(demo_config(tf=tf))
    return receive(config, ["--duration", "3", *options], folder)


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> tuple[Received, Path]:
    folder = tmp_path_factory.mktemp("rig")
    return received_with(folder, {"layout": "rig"}), folder


def test_in_the_rig_layout_only_the_head_moves(rig: tuple[Received, Path]) -> None:
    assert {child for child, _ in moving(rig[0])} == {"head_frame"}


def test_static_transforms_are_kept_for_late_subscribers(rig: tuple[Received, Path]) -> None:
    assert rig[0].qos["/tf_static"] == {("RELIABLE", "TRANSIENT_LOCAL")}


@pytest.mark.parametrize("camera", CAMERAS)
def test_sensors_stand_where_the_simulation_has_mounted_them(
    rig: tuple[Received, Path], camera: str
) -> None:
    mount = json.loads(SimulatedTruth.now().library.ml2sim_mounts())[camera]
    x, y, z, w = mount["rotation"]
    device, true = pose_matrix(mount["position"], w, x, y, z), np.eye(4)
    true[:3, :3] = TO_ROS @ device[:3, :3] @ OPTICAL
    true[:3, 3] = TO_ROS @ device[:3, 3]
    found = standing(rig[0])[f"{camera}_optical_frame"]
    assert np.linalg.norm(found[:3, 3] - true[:3, 3]) < 0.001
    assert np.degrees(angle_between(found, true)) < 0.05


@pytest.mark.parametrize("camera", CAMERAS)
def test_how_rigid_a_mounting_is_stands_in_the_log(rig: tuple[Received, Path], camera: str) -> None:
    _, folder = rig
    said = (folder / "receiver.log").read_text()
    assert f"{camera} is where its last 30 frames have it: median 0.0" in said


def test_while_the_head_is_not_tracked_there_are_images_but_no_transforms(tmp_path: Path) -> None:
    received = received_with(tmp_path, {}, "--simulate", "fault.head.tracking=2")
    for camera in CAMERAS:
        assert len(received.messages(image_topic(camera))) > 20
    assert received.messages("/tf") == []
