"""Trajectories as TUM files: seconds, then x y z in metres, then the quaternion x y z w."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np

from ..errors import EvaluationError
from ..export.pose import Pose, pose_of
from .estimator import Trajectory

_MOST_BYTES = 100_000_000
_NANOS_PER_SECOND = 1_000_000_000


def write_tum(path: Path, trajectory: Trajectory) -> None:
    """All nine decimals of each stamp are kept."""
    with path.open("w") as file:
        file.writelines(_line(stamp_ns, pose) for stamp_ns, pose in trajectory)


def read_tum(path: Path) -> Trajectory:
    """By rising stamp; `#` begins a comment.

    Raises:
        EvaluationError: it cannot be read, or is another format.
    """
    try:
        with path.open("rb") as file:
            text = file.read(_MOST_BYTES + 1)
    except OSError as error:
        raise EvaluationError(f"cannot read {path}: {error.strerror}") from error
    if len(text) > _MOST_BYTES:
        raise EvaluationError(f"{path} has over {_MOST_BYTES} B, too many for a trajectory")
    poses: dict[int, Pose] = {}
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition(b"#")[0].decode("ascii", "replace").split()
        try:
            poses |= [_pose(words)] if words else []
        except ValueError as error:
            raise EvaluationError(f"{path}:{number}: {error}") from error
    return sorted(poses.items())


def _line(stamp_ns: int, pose: Pose) -> str:
    seconds, nanos = divmod(stamp_ns, _NANOS_PER_SECOND)
    numbers = " ".join(f"{it:.9f}" for it in (*pose[:3, 3], *_quaternion(pose)))
    return f"{seconds}.{nanos:09d} {numbers}\n"


def _quaternion(pose: Pose) -> tuple[float, ...]:
    """x y z w."""
    vector = cv2.Rodrigues(pose[:3, :3])[0].ravel()
    angle = float(np.linalg.norm(vector))
    x, y, z = vector * (math.sin(angle / 2) / angle) if angle else vector
    return float(x), float(y), float(z), math.cos(angle / 2)


def _pose(words: list[str]) -> tuple[int, Pose]:
    if len(words) != 8:
        raise ValueError(f"expected 8 numbers, found {len(words)} words")
    seconds, _, decimals = words[0].partition(".")
    stamp_ns = int(seconds) * _NANOS_PER_SECOND + int(decimals[:9].ljust(9, "0"))
    x, y, z, qx, qy, qz, qw = map(float, words[1:])
    translation = SimpleNamespace(x=x, y=y, z=z)
    rotation = SimpleNamespace(x=qx, y=qy, z=qz, w=qw)
    return stamp_ns, pose_of(SimpleNamespace(translation=translation, rotation=rotation))
