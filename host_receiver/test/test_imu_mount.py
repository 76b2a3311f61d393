"""Mounts of inertial units from drawn motions, against the drawn mounts."""

import re
from dataclasses import replace

import numpy as np
import pytest

from head_motion import HeadMotion
from ml2_receiver.errors import CalibrationError
from ml2_tools.calibration.imu import estimate_mount
from ml2_tools.calibration.motion import Samples

_DURATION_S = 23.0


def test_a_drawn_mount_is_found_within_what_is_stated() -> None:
    motion = HeadMotion(seed=1)
    true = motion.mount
    found = estimate_mount(motion.observed(_DURATION_S))
    turned = (found.rotation * true.rotation.inv()).magnitude()
    moved_m = np.linalg.norm(found.translation_m - true.translation_m)
    late_s = abs(found.time_offset_s - true.time_offset_s)
    assert np.degrees(turned) < 0.1
    assert moved_m < 0.005
    assert late_s < 0.2e-3
    # Two sigma in each axis hold for 95 of 100 draws: of this one, three do.
    assert turned < 3 * np.linalg.norm(found.rotation_sigma_rad)
    assert moved_m < 3 * np.linalg.norm(found.translation_sigma_m)
    assert late_s < 3 * found.time_offset_sigma_s
    assert 0 < np.degrees(found.rotation_sigma_rad.max()) < 0.1
    assert 0 < found.translation_sigma_m.max() < 0.005


def test_late_poses_are_a_time_offset() -> None:
    motion = HeadMotion(seed=2)
    found = estimate_mount(motion.observed(_DURATION_S, delay_s=0.02))
    assert found.time_offset_s == pytest.approx(motion.mount.time_offset_s - 0.02, abs=0.2e-3)


@pytest.mark.parametrize(
    ("turning", "asked"),
    [
        ((0, 0, 1), r"^Record again, and tilt .*front-back.* and nod .*left-right.* too\.$"),
        ((0, 1, 0), r"^Record again, and tilt .*front-back.* and shake .*up-down.* too\.$"),
        ((0.01, 0.01, 0.01), r"^Record again, and turn faster, about all axes\.$"),
    ],
)
def test_too_little_motion_is_refused_with_what_is_missing(
    turning: tuple[float, float, float], asked: str
) -> None:
    with pytest.raises(CalibrationError, match="does not show how the unit is mounted") as refused:
        estimate_mount(HeadMotion(5, turning).observed(_DURATION_S))
    assert re.match(asked, refused.value.hint or "")


def test_what_lies_in_gaps_is_not_used() -> None:
    motion = HeadMotion(seed=3)
    whole = motion.observed(_DURATION_S)
    turns = whole.gyroscope
    is_there = (turns.stamps_s < 10) | (turns.stamps_s > 10.5)
    broken = Samples(turns.stamps_s[is_there], turns.values[is_there])
    found = estimate_mount(replace(whole, gyroscope=broken))
    assert np.degrees((found.rotation * motion.mount.rotation.inv()).magnitude()) < 0.1
    # From the end of the beginning's margin to that of the end, without the gap.
    assert found.duration_s == pytest.approx(_DURATION_S - 0.8 - 0.5, abs=0.05)


def test_a_short_recording_is_refused_with_its_length() -> None:
    with pytest.raises(CalibrationError, match=r"for 20 s or more, found 9\.[12] s"):
        estimate_mount(HeadMotion(4).observed(10.0))
