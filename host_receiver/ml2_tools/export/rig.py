"""The cameras and the IMU of a headset, from a recording or from live topics."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ml2_receiver.configuration.calibration import Calibration

from ..geometry.pose import Pose, weighted_mean
from .kalibr import Mounting, RigCamera

# Between poses of the head that are further apart it is not known.
_LONGEST_GAP_NS = 50_000_000


@dataclass(frozen=True)
class Rig:
    """The cameras in the requested order, with poses at one stamp, and the IMU's rate.

    `mounting` is that of the IMU among the cameras, as calibrated; None if it is not known.
    """

    cameras: tuple[RigCamera, ...]
    imu_rate_hz: float | None
    mounting: Mounting | None = None


def calibration_of(info: Any) -> Calibration:
    """Returns the calibration in a sensor_msgs/CameraInfo."""
    rows = (tuple(map(float, it)) for it in (info.d, info.k, info.r, info.p))
    return Calibration(info.width, info.height, info.distortion_model, *rows)


def rate_hz(stamps_ns: Collection[int]) -> float | None:
    """Returns the rate at which a sensor measures, also if some of its messages were lost.

    None for less than two stamps.
    """
    periods_ns = np.diff(sorted(stamps_ns))
    if not periods_ns.size:
        return None
    # A lost message leaves twice the period.
    return 1e9 / float(periods_ns[periods_ns <= 1.5 * np.median(periods_ns)].mean())


def add_rising(stamps_ns: list[int], at_ns: int) -> None:
    """Adds the stamp of the next message.

    Raises:
        ValueError: it is not later than the last one.
    """
    if stamps_ns and at_ns <= stamps_ns[-1]:
        hint = "run `ml2-receiver inspect` for details"
        raise ValueError(f"stamp {at_ns} comes after {stamps_ns[-1]}: {hint}")
    stamps_ns.append(at_ns)


def head_in(
    instants: Mapping[int, Mapping[str, Pose]], heads: Mapping[int, Pose], camera: str
) -> Pose | None:
    """Returns the pose of the head in a camera: the mean over all instants at which both are known.

    Args:
        instants: poses in the world by camera, by stamp in ns.
        heads: poses in the world by stamp in ns; between them the head's is interpolated.
    """
    known_ns = np.array(sorted(heads))
    found = []
    for at_ns, poses in instants.items():
        after = int(np.searchsorted(known_ns, at_ns))
        if at_ns in heads:
            found.append(np.linalg.inv(poses[camera]) @ heads[at_ns])
        elif 0 < after < len(known_ns):
            begin_ns, end_ns = map(int, known_ns[after - 1 : after + 1])
            if end_ns - begin_ns <= _LONGEST_GAP_NS:
                share = (at_ns - begin_ns) / (end_ns - begin_ns)
                pair = np.stack([heads[begin_ns], heads[end_ns]])
                head = weighted_mean(pair, np.array([1 - share, share]))
                found.append(np.linalg.inv(poses[camera]) @ head)
    if not found:
        return None
    return weighted_mean(np.stack(found), np.full(len(found), 1 / len(found)))
