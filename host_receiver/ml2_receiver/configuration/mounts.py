"""The mounts of headsets' inertial units, as `ml2-receiver calibrate` estimated them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import hypot, isfinite
from pathlib import Path
from typing import Any

import yaml

from ..errors import CalibrationError
from ..private_files import make_private_folder
from ..user_folder import user_folder
from .whole_file import read_file, replace_file
from .yaml_tree import TreeLoader

_MAX_BYTES = 256 * 1024
_HEADER = """\
# Inertial units by device id and stream, as `ml2-receiver calibrate imu` found them.
# `ml2-receiver calibrate imu --forget` deletes them.
"""


@dataclass(frozen=True)
class Mount:
    """The pose of a unit in head_frame (REP-103), and what else was found with it.

    Attributes:
        rotation: the unit quaternion x, y, z, w, from the unit's axes to the head's.
        time_offset_s: what to add to the stamps of head poses for those of the unit.
        gyroscope_bias: rad/s, in the unit's axes, as is `accelerometer_bias`, in m/s^2.
        rotation_sigma_deg: standard deviations, about each of the head's axes.
        calibrated: when, in UTC.
    """

    translation_m: tuple[float, ...]
    rotation: tuple[float, ...]
    time_offset_s: float
    gyroscope_bias: tuple[float, ...]
    accelerometer_bias: tuple[float, ...]
    translation_sigma_m: tuple[float, ...]
    rotation_sigma_deg: tuple[float, ...]
    time_offset_sigma_s: float
    calibrated: str


type Mounts = Mapping[str, Mapping[str, Mount]]


def mounts_file() -> Path:
    return user_folder() / "imu_mounts.yaml"


def load_mounts() -> Mounts:
    """Returns the mounts by device id and stream; empty if there is no file.

    Raises:
        CalibrationError: the file cannot be read, or is not as save_mounts() writes it.
    """
    path = mounts_file()
    try:
        data = read_file(path, _MAX_BYTES)
        if len(data) > _MAX_BYTES:
            raise CalibrationError(f"{path}: expected at most {_MAX_BYTES} bytes")
        document = yaml.load(data, TreeLoader)
        return {
            str(device): {str(stream): _mount(it) for stream, it in units.items()}
            for device, units in (document or {}).items()
        }
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise CalibrationError(f"{path} cannot be read: {error.strerror}") from error
    except (yaml.YAMLError, RecursionError, ValueError, TypeError, AttributeError) as error:
        raise CalibrationError(
            f"{path}: {' '.join(str(error).split())}",
            hint="Delete the file, and calibrate again with `ml2-receiver calibrate imu`.",
        ) from error


def _mount(values: Mapping[str, Any]) -> Mount:
    fields: dict[str, Any] = {
        key: tuple(map(float, it)) if isinstance(it, list) else it for key, it in values.items()
    }
    mount = Mount(**fields)
    lengths = {"translation_m": 3, "rotation": 4}
    for key, length in lengths.items():
        numbers = fields[key]
        if not isinstance(numbers, tuple) or len(numbers) != length:
            raise ValueError(f"{key}: expected {length} numbers, found {numbers!r}")
        if not all(map(isfinite, numbers)):
            raise ValueError(f"{key}: expected finite numbers, found {numbers!r}")
    if abs(hypot(*mount.rotation) - 1) > 1e-3:
        raise ValueError(f"rotation: expected a unit quaternion, found {mount.rotation!r}")
    return mount


def save_mounts(mounts: Mounts) -> None:
    """Replaces the file, all or nothing.

    Raises:
        CalibrationError: it cannot be written.
    """
    path = mounts_file()
    document = {
        device: {stream: _plain(it) for stream, it in units.items()}
        for device, units in mounts.items()
    }
    text = _HEADER + yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=100)
    try:
        if not path.parent.exists():
            make_private_folder(path.parent)
        replace_file(path, text.encode())
    except OSError as error:
        raise CalibrationError(f"{path} cannot be written: {error.strerror or error}") from error


def _plain(mount: Mount) -> dict[str, Any]:
    return {key: list(it) if isinstance(it, tuple) else it for key, it in asdict(mount).items()}
