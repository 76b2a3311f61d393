"""The simulated controller through both of the device's interfaces."""

from __future__ import annotations

import pytest

from capture_stamps import stamp_ns
from full_load import FullLoad
from processes import Received
from transforms import moving


@pytest.fixture(params=["flat", "rig"], ids=["sdk", "openxr"])
def held(request: pytest.FixtureRequest) -> Received:
    load: FullLoad = request.getfixturevalue(request.param)
    return load.received


def test_its_pose_is_its_transform(held: Received) -> None:
    poses = {stamp_ns(it): it.pose.position for it in held.messages("controller")}
    frames = {at: pose for (child, at), pose in moving(held).items() if child == "controller_frame"}
    common = poses.keys() & frames.keys()
    assert len(common) > 0.5 * len(poses)  # both may lose some under load
    for at in common:
        position = poses[at]
        assert frames[at][:3, 3] == pytest.approx([position.x, position.y, position.z])


def test_every_button_and_axis_changes(held: Received) -> None:
    states = held.messages("controller/joy")
    assert {(len(it.axes), len(it.buttons)) for it in states} == {(4, 3)}
    for button in range(3):
        assert {it.buttons[button] for it in states} == {0, 1}
    for axis, least in enumerate((0, -1, -1, 0)):  # trigger, x, y, force
        values = {it.axes[axis] for it in states}
        assert len(values) > 1
        assert least <= min(values) < max(values) <= 1
