"""The layouts of the transform tree, and what becomes of it while the head is not tracked."""

from __future__ import annotations

import contextlib
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from capture_stamps import stamp_ns
from euroc import angle_between, pose_matrix
from processes import Received, headset_command, lines, receive, result, subscribing
from room import TO_ROS
from simulated_truth import OPTICAL, SimulatedTruth
from simulation import CAMERAS, demo_config, image_topic
from stage import staged
from transforms import moving, stable_since_ns, standing


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


def test_transforms_end_and_begin_with_the_tracking(tmp_path: Path) -> None:
    received = received_with(
        tmp_path,
        {},
        *("--simulate", "fault.head.tracking=2@0.8"),
        *("--simulate", "fault.head.tracking=0@2"),
    )
    heads = sorted(at for child, at in moving(received) if child == "head_frame")
    gap_ns, begin = max((b - a, a) for a, b in itertools.pairwise(heads))
    assert 0.8e9 < gap_ns < 1.6e9
    in_between = [at for at in stamps_of(received, CAMERAS[0]) if begin < at < begin + gap_ns]
    assert len(in_between) > 15
    said = (tmp_path / "receiver.log").read_text()
    assert said.index("head tracking is lost") < said.index("head tracking is recovered")


def test_a_new_world_is_announced(tmp_path: Path) -> None:
    received_with(tmp_path, {}, "--simulate", "fault.head.new_session=1@1")
    assert "head tracking begins anew" in (tmp_path / "receiver.log").read_text()


def test_a_late_subscriber_gets_the_mountings(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(demo_config(tf={"layout": "rig"}))
    late_folder = tmp_path / "late"
    late_folder.mkdir()
    with contextlib.ExitStack() as stack:
        stage = stack.enter_context(staged(config, tmp_path))
        with stage.started("headset", headset_command(stage.address)):
            stage.await_seconds(3)
            subscriber = stack.enter_context(subscribing(stage.environment, late_folder))
            for _ in range(2):
                assert next(lines(subscriber))
        late = result(subscriber, late_folder)
        received = stage.result()
    mounted_ns = stable_since_ns(received)
    assert mounted_ns is not None
    assert min(stamps_of(late, CAMERAS[0])) > mounted_ns
    assert standing(late).keys() == standing(received).keys()
    assert {f"{camera}_optical_frame" for camera in CAMERAS} <= standing(late).keys()


def stamps_of(received: Received, camera: str) -> list[int]:
    return [stamp_ns(it) for it in received.messages(image_topic(camera))]
