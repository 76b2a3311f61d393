"""Reads and writes TUM files: seconds, then x y z in metres, then the quaternion x y z w."""

import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np

from ml2_receiver.configuration.whole_file import read_file

from ..errors import EvaluationError
from ..geometry.pose import Pose, pose_of
from .trajectory import Trajectory

_MOST_BYTES = 100_000_000
_NANOS_PER_SECOND = 1_000_000_000


def write_tum(path: Path, trajectory: Trajectory) -> None:
    """Writes a TUM file; stamps have all nine decimals."""
    with path.open("w") as file:
        file.writelines(_line(stamp_ns, pose) for stamp_ns, pose in trajectory)


def read_tum(path: Path) -> Trajectory:
    """Reads a TUM file, by rising stamp; `#` begins a comment.

    Raises:
        EvaluationError: the file cannot be read, or has another format.
    """
    return read_rows(path, tum_row)


def read_rows(path: Path, row: Callable[[list[str]], tuple[int, Pose]]) -> Trajectory:
    """Reads a file like a TUM file whose rows have another format.

    Args:
        row: returns stamp_ns and the pose of a line's words, or raises ValueError.

    Raises:
        EvaluationError: the file cannot be read, or has another format.
    """
    try:
        text = read_file(path, _MOST_BYTES)
    except OSError as error:
        raise EvaluationError(f"cannot read {path}: {error.strerror}") from error
    if len(text) > _MOST_BYTES:
        raise EvaluationError(f"{path} has over {_MOST_BYTES} B, too many for a trajectory")
    poses: dict[int, Pose] = {}
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition(b"#")[0].decode("ascii", "replace").split()
        try:
            poses |= [row(words)] if words else []
        except ValueError as error:
            raise EvaluationError(f"{path}:{number}: {error}") from error
    return sorted(poses.items())


def _line(stamp_ns: int, pose: Pose) -> str:
    seconds, nanos = divmod(stamp_ns, _NANOS_PER_SECOND)
    numbers = " ".join(f"{it:.9f}" for it in (*pose[:3, 3], *quaternion(pose)))
    return f"{seconds}.{nanos:09d} {numbers}\n"


def quaternion(pose: Pose) -> tuple[float, ...]:
    """Returns the rotation of a 4x4 matrix as x y z w."""
    vector = cv2.Rodrigues(pose[:3, :3])[0].ravel()
    angle = float(np.linalg.norm(vector))
    x, y, z = vector * (math.sin(angle / 2) / angle) if angle else vector
    return float(x), float(y), float(z), math.cos(angle / 2)


def tum_row(words: list[str]) -> tuple[int, Pose]:
    """Returns stamp_ns and the pose of a TUM file's row.

    Raises:
        ValueError: the row has another format.
    """
    if len(words) != 8:
        raise ValueError(f"expected 8 numbers, found {len(words)} words")
    return nanos_of(words[0]), pose_of_words(words[1:4], words[4:])


def nanos_of(seconds: str) -> int:
    """Converts decimal seconds to ns without rounding."""
    whole, _, decimals = seconds.partition(".")
    return int(whole) * _NANOS_PER_SECOND + int(decimals[:9].ljust(9, "0"))


def pose_of_words(position: list[str], quaternion: list[str]) -> Pose:
    """Returns the pose of a position x y z and a quaternion x y z w."""
    x, y, z = map(float, position)
    qx, qy, qz, qw = map(float, quaternion)
    translation = SimpleNamespace(x=x, y=y, z=z)
    rotation = SimpleNamespace(x=qx, y=qy, z=qz, w=qw)
    return pose_of(SimpleNamespace(translation=translation, rotation=rotation))
