"""The poses and readings of the simulated headset are true at their stamps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from capture_stamps import stamp_ns
from euroc import Matrix, angle_between, interpolated
from full_load import FullLoad
from processes import Received
from simulated_truth import SimulatedTruth
from simulation import CAMERAS, image_topic
from transforms import stable_since_ns, transforms

SHIFT_NS = 5_000_000
# Head poses come every 17 ms. In a longer interval, a busy machine has dropped some.
LONGEST_INTERVAL_NS = 20_000_000
# The least number of images with a pose; a busy machine drops many.
MIN_IMAGES = 20
GYRO = "gyro_left/imu"
UNIT = "imu_left"


@dataclass(frozen=True)
class Run:
    """The received messages and the true poses."""

    received: Received
    tree: dict[tuple[str, int], Matrix]
    stamps_ns: dict[str, list[int]]
    truth: SimulatedTruth

    def with_images(self, camera: str) -> Iterator[tuple[int, Matrix]]:
        """Yields each image's stamp and the transform with exactly that stamp."""
        heads = self.head_stamps_ns()
        begin = stable_since_ns(self.received) or heads[0]
        stamps = [at for at in self.stamps_ns[camera] if begin < at < heads[-1]]
        known = [at for at in stamps if (f"{camera}_optical_frame", at) in self.tree]
        lost = int(self.received.counters("/tf")["produced"]) - len(self.received.messages("/tf"))
        # Poses of this camera that a busy machine asked for too late are not counted.
        late = len(stamps) / 10 if camera == "color" else 0
        assert len(stamps) - len(known) <= lost + late
        assert len(known) > MIN_IMAGES
        return ((at, self.tree[f"{camera}_optical_frame", at]) for at in known)

    def head_stamps_ns(self) -> list[int]:
        """Returns the stamps of the transforms at 60 Hz."""
        of_images = set().union(*self.stamps_ns.values())
        heads = {at for child, at in self.tree if child == "head_frame"}
        return sorted(heads - of_images)

    def between_head_poses(self, camera: str) -> Iterator[tuple[int, Matrix]]:
        """Yields each image's stamp and the pose interpolated from the transforms at 60 Hz."""
        child = f"{camera}_optical_frame"
        heads = [at for at in self.head_stamps_ns() if (child, at) in self.tree]
        poses = {at: self.tree[child, at] for at in heads}
        found = []
        for at in self.stamps_ns[camera]:
            after = int(np.searchsorted(heads, at))
            if 0 < after < len(heads) and heads[after] - heads[after - 1] < LONGEST_INTERVAL_NS:
                found.append((at, interpolated(poses, at)))
        assert len(found) > MIN_IMAGES
        return iter(found)

    def worst(
        self, camera: str, found: Iterator[tuple[int, Matrix]], shift_ns: int = 0
    ) -> tuple[float, float]:
        """Returns the largest errors of the poses in mm and degrees, if stamps were shifted."""
        errors = [
            (
                1000 * float(np.linalg.norm(pose[:3, 3] - true[:3, 3])),
                float(np.degrees(angle_between(pose, true))),
            )
            for at, pose in found
            for true in [self.truth.optical_frame(camera, at + shift_ns)]
        ]
        worst_mm, worst_deg = np.max(errors, axis=0)
        print(f"{camera}, shifted by {shift_ns} ns: {worst_mm:.3f} mm, {worst_deg:.4f} deg")
        return worst_mm, worst_deg


@pytest.fixture(scope="module", params=["flat", "rig"])
def run(request: pytest.FixtureRequest) -> Run:
    load: FullLoad = request.getfixturevalue(request.param)
    stamps_ns = {
        camera: [stamp_ns(it) for it in load.received.messages(image_topic(camera))]
        for camera in CAMERAS
    }
    return Run(load.received, transforms(load.received), stamps_ns, load.truth)


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_transform_of_an_image_is_the_true_pose_at_its_stamp(run: Run, camera: str) -> None:
    worst_mm, worst_deg = run.worst(camera, run.with_images(camera))
    assert worst_mm < 1
    assert worst_deg < 0.05


@pytest.mark.parametrize("camera", CAMERAS)
def test_transforms_at_60_hz_lead_to_the_true_pose_of_an_image(run: Run, camera: str) -> None:
    worst_mm, worst_deg = run.worst(camera, run.between_head_poses(camera))
    assert worst_mm < 3
    assert worst_deg < 0.15


@pytest.mark.parametrize("camera", CAMERAS)
def test_stamps_that_are_5_ms_off_would_be_noticed(run: Run, camera: str) -> None:
    for shift_ns in (SHIFT_NS, -SHIFT_NS):
        worst_mm, worst_deg = run.worst(camera, run.with_images(camera), shift_ns)
        assert worst_mm > 1
        assert worst_deg > 0.05
        worst_mm, worst_deg = run.worst(camera, run.between_head_poses(camera), shift_ns)
        assert worst_deg > 0.15 or worst_mm > 3


def test_the_gyroscope_turns_as_the_camera_truly_does(run: Run) -> None:
    camera = "world_left"
    samples = [(stamp_ns(it), it.angular_velocity) for it in run.received.messages(GYRO)]
    stamps = np.array([at for at, _ in samples])
    rates = np.array([[it.x, it.y, it.z] for _, it in samples])
    to_imu = run.truth.imu_in_optical_frame(UNIT, camera)
    errors: dict[int, list[float]] = {200: [], 40: []}
    for start, end in seconds(run.stamps_ns[camera], stamps):
        speeds = np.degrees(np.linalg.norm(rates[(stamps > start) & (stamps < end)], axis=1))
        if np.ptp(speeds) < 100:
            continue
        true = np.linalg.inv(run.truth.optical_frame(camera, start)) @ run.truth.optical_frame(
            camera, end
        )
        for rate_hz, found in errors.items():
            each = 200 // rate_hz
            turned = to_imu @ integrated(stamps[::each], rates[::each], start, end) @ to_imu.T
            found.append(float(np.degrees(angle_between(turned, true))))
    print({f"{rate_hz} Hz": f"{max(found):.3f} deg" for rate_hz, found in errors.items()})
    assert len(errors[200]) >= 3  # a busy machine may have dropped readings in all others
    assert max(errors[200]) < 0.2


def seconds(images: list[int], gyro: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Yields pairs of images one second apart with no missing reading at 200 Hz in between."""
    for start in images:
        end = next((at for at in images if at - start > 999_000_000), None)
        if end is None or end - start > 1_001_000_000:
            continue
        inside = gyro[(gyro > start - 6_000_000) & (gyro < end + 6_000_000)]
        if len(inside) and inside[0] <= start and inside[-1] >= end and np.diff(inside).max() < 6e6:
            yield start, end


def integrated(stamps: NDArray[np.int64], rates: NDArray[Any], start: int, end: int) -> Matrix:
    """Returns the rotation from start to end; rates are interpolated linearly between readings."""
    inside = stamps[(stamps > start) & (stamps < end)]
    times_s = (np.concatenate([[start], inside, [end]]) - start) / 1e9
    known_s = (stamps - start) / 1e9
    at_times = np.stack([np.interp(times_s, known_s, axis) for axis in rates.T], axis=1)
    turned: Matrix = np.eye(3)
    for step_s, one, next_one in zip(np.diff(times_s), at_times, at_times[1:], strict=False):
        turned = turned @ cv2.Rodrigues((one + next_one) / 2 * step_s)[0]
    return turned
