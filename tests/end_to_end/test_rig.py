"""The layout "rig" of the transform tree: sensors are fixed to the head, which moves."""

from __future__ import annotations

import json

import numpy as np
import pytest

from euroc import angle_between, pose_matrix
from full_load import FullLoad
from simulated_scene import TO_ROS
from simulated_truth import OPTICAL, SimulatedTruth
from simulation import CAMERAS
from transforms import mounted, moving


def test_in_the_rig_layout_only_head_and_controller_move(rig: FullLoad) -> None:
    assert {child for child, _ in moving(rig.received)} == {"head_frame", "controller_frame"}


def test_static_transforms_are_kept_for_late_subscribers(rig: FullLoad) -> None:
    assert rig.received.qos["/tf_static"] == {("RELIABLE", "TRANSIENT_LOCAL")}


@pytest.mark.parametrize("camera", CAMERAS)
def test_sensors_are_where_the_simulation_mounts_them(rig: FullLoad, camera: str) -> None:
    mount = json.loads(SimulatedTruth.now().library.ml2sim_mounts())[camera]
    x, y, z, w = mount["rotation"]
    device, true = pose_matrix(mount["position"], w, x, y, z), np.eye(4)
    true[:3, :3] = TO_ROS @ device[:3, :3] @ OPTICAL
    true[:3, 3] = TO_ROS @ device[:3, 3]
    found = mounted(rig.received)[f"{camera}_optical_frame"]
    assert np.linalg.norm(found[:3, 3] - true[:3, 3]) < 0.001
    assert np.degrees(angle_between(found, true)) < 0.05


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_log_says_how_stable_a_mounting_is(rig: FullLoad, camera: str) -> None:
    assert f"the mounting of {camera} is stable over its last 30 frames: median 0.0" in rig.log
