"""Trajectories as other programs write them, and what no program writes."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from command_line import refusal
from ml2_tools.errors import EvaluationError
from ml2_tools.evaluation.slam_files import read_trajectory

# sin and cos of 45 degrees: half of a quarter turn
S = "0.707107"
ORB_SLAM3 = f"""\
1403715273262142976.000000 0.100000001 0.200000003 0.300000012 0.000000000 0.000000000 {S} {S}
1403715273312143104.000000 0.1 0.2 0.4 0 0 0 1
"""
STATE_HEAD = "# timestamp(s) q p v bg ba cam_imu_dt num_cam cam0_k cam0_d cam0_rot cam0_trans ...\n"


def state(time: str, imu: str, camera: str) -> str:
    """A line of OpenVINS's total state: q and p of the IMU, and of it in the camera's frame."""
    still, lens = " ".join(["0.0"] * 9), " ".join(["1.0"] * 8)
    return f"{time} {imu} {still} 0.000000 1 {lens} {camera} 1.0 0.0\n"


def test_orb_slam3_has_nanoseconds_and_the_camera(tmp_path: Path) -> None:
    (tmp_path / "f.txt").write_text(ORB_SLAM3)
    (first_ns, first), (second_ns, _) = read_trajectory(tmp_path / "f.txt")
    assert (first_ns, second_ns) == (1403715273262142976, 1403715273312143104)
    assert first[:3, 3] == pytest.approx([0.1, 0.2, 0.3])
    quarter, _ = cv2.Rodrigues(np.array([0, 0, np.pi / 2]))
    assert first[:3, :3] == pytest.approx(quarter, abs=1e-5)


def test_open_vins_has_the_imu_from_which_the_camera_follows(tmp_path: Path) -> None:
    """The IMU stands at (1, 2, 3), turned by 90 degrees about z. The camera's axes are the IMU's
    turned by 90 degrees about x. It stands 0.5 m along the IMU's x axis, which is the world's y
    axis, and 0.2 m along its y axis, which is the world's x axis backwards. JPL's quaternion from
    world to IMU is Hamilton's from IMU to world."""
    rotation, _ = cv2.Rodrigues(np.array([np.pi / 2, 0, 0]))
    imu_in_camera = -rotation.T @ [0.5, 0.2, 0]
    camera = f"{S} 0.0 0.0 {S} " + " ".join(f"{it:.6f}" for it in imu_in_camera)
    line = state("1403715273.26214", f"0.0 0.0 {S} {S} 1.0 2.0 3.0", camera)
    (tmp_path / "state.txt").write_text(STATE_HEAD + line)
    ((at_ns, pose),) = read_trajectory(tmp_path / "state.txt")
    assert at_ns == 1403715273262140000
    assert pose[:3, 3] == pytest.approx([0.8, 2.5, 3.0], abs=1e-5)
    imu, _ = cv2.Rodrigues(np.array([0, 0, np.pi / 2]))
    assert pose[:3, :3] == pytest.approx(imu @ rotation, abs=1e-5)


def test_a_tum_file_is_understood_too(tmp_path: Path) -> None:
    (tmp_path / "it.tum").write_text("# a comment\n12.000000345 1 2 3 0 0 0 1\n")
    ((at_ns, pose),) = read_trajectory(tmp_path / "it.tum")
    assert at_ns == 12_000_000_345
    assert pose[:3, 3].tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    "text",
    [
        "1403715273262142976.0 0 0 0 0 0 0\n",
        "1403715273262142976.0 0 0 0 0 0 0 0\n",
        "1403715273262142976.0 nan 0 0 0 0 0 1\n",
        "inf 0 0 0 0 0 0 1\n",
        "1e18 0 0 0 0 0 0 1\n",
        "five 0 0 0 0 0 0 1\n",
        "1.0 2.0 3.0 4.0 5.0 6.0 7.0 8.0 " * 5 + "\n",
        "\xff\xfe\n",
    ],
)
def test_what_is_no_trajectory_is_refused_with_its_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "f.txt").write_text(ORB_SLAM3 + text)
    with pytest.raises(EvaluationError, match=r"f\.txt:3: "):
        read_trajectory(tmp_path / "f.txt")


def test_a_trajectory_is_of_a_recording() -> None:
    options = ["evaluate", "--live", "--camera", "world_left", "--trajectory", "f.txt"]
    expected = "--trajectory needs a recording: name it with --bag, not --live"
    assert expected in refusal(*options)
