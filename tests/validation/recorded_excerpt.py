"""Evaluates the recorded excerpt of EuRoC, replayed through ROS 2.

The drone does not move, and a camera at rest shows no depth. So the estimator gets the images of
both cameras as those of one camera that jumps between the two positions.
"""

import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ml2_tools.evaluation.evaluation import agreement, figures_of
from ml2_tools.evaluation.sequence import Sequence, read_sequence
from ml2_tools.evaluation.structure_from_motion import structure_from_motion
from ml2_tools.evaluation.trajectory import Images, Trajectory
from ml2_tools.geometry.camera import Camera
from ml2_tools.geometry.lens import Lens
from ml2_tools.images.rectification import rectify
from processes import EXCERPT, receive
from simulated_walk import record
from simulation import raw_config

_CAMERAS = ("world_left", "world_right")
# The time between the two images of one stamp: above the resolution of evo's stamps, too short for
# motion.
_JUMP_NS = 1000


def evaluate_excerpt(folder: Path) -> dict[str, Any]:
    """Returns an entry of the report; the reference is the ground truth in /tf."""
    folder.mkdir(parents=True)
    config = folder / "config.yaml"
    config.write_text(raw_config())
    received = receive(config, ["--replay", str(EXCERPT)], folder)
    record(received, folder / "bag", 0, sys.maxsize)
    cameras = [read_sequence(folder / "bag", camera) for camera in _CAMERAS]
    estimate = structure_from_motion(_images(cameras), _pinhole(cameras[0].camera))
    reference = _reference(cameras)
    return {
        "trajectory": "EuRoC V1_01, excerpt at rest",
        "camera": " and ".join(_CAMERAS),
        "estimator": "sfm",
        "duration_s": (reference[-1][0] - reference[0][0]) / 1e9,
        "images_sent": sum(it.images_sent for it in cameras),
        "images_received": sum(len(it.stamps_ns) for it in cameras),
        "images_placed": len(estimate),
        **figures_of(agreement(reference, estimate)),
        "truth": None,
        "baseline_m": _baseline_m(reference),
    }


def _jumping[T](one: Iterable[T], other: Iterable[T]) -> Iterator[tuple[int, T]]:
    """Yields left, right, left, right, right, left, right, left, ..., with the index in a pair.

    The order makes key images, which are every fourth image, alternate between the cameras.
    """
    for index, pair in enumerate(zip(one, other, strict=True)):
        yield from enumerate(pair[::-1] if index // 2 % 2 else pair)


def _images(cameras: list[Sequence]) -> Images:
    """Yields the images of both cameras, rectified to the left camera's pinhole."""
    matrix = cameras[0].camera.matrix
    rectified = (
        [(at, rectify(image, replace(it.camera, matrix=matrix))) for at, image in it.images()]
        for it in cameras
    )
    for jumps, (at, image) in _jumping(*rectified):
        yield at + jumps * _JUMP_NS, image


def _reference(cameras: list[Sequence]) -> Trajectory:
    known = ([(at, pose) for at, pose in it.reference if at in set(it.stamps_ns)] for it in cameras)
    return [(at + jumps * _JUMP_NS, pose) for jumps, (at, pose) in _jumping(*known)]


def _pinhole(camera: Camera) -> Camera:
    fx, _, cx, _, fy, cy, *_ = camera.matrix
    lens = Lens(camera.lens.width, camera.lens.height, fx, fy, cx, cy, "plumb_bob", (0.0,) * 5)
    return replace(camera, lens=lens)


def _baseline_m(reference: Trajectory) -> float:
    """Returns the distance between the cameras by the ground truth."""
    (_, one), (_, other) = reference[:2]
    return float(np.linalg.norm(one[:3, 3] - other[:3, 3]))
