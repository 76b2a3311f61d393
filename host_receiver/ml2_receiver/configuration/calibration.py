"""Camera calibrations in files as ROS's camera_calibration writes them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import yaml

from ..errors import CalibrationError
from .whole_file import read_file, replace_file
from .yaml_tree import TreeLoader

_MAX_BYTES = 64 * 1024
# sensor_msgs/distortion_models.hpp, and how many coefficients ROS programs read for each.
_MODELS = {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}


@dataclass(frozen=True)
class Calibration:
    """The values of CameraInfo without its header; matrices row by row, lengths in pixels."""

    width: int
    height: int
    model: str
    d: tuple[float, ...]
    k: tuple[float, ...]
    r: tuple[float, ...]
    p: tuple[float, ...]


def load_calibration(path: Path) -> Calibration:
    """Reads a file in the format of camera_info_manager.

    Raises:
        CalibrationError: it cannot be read, or is no calibration; says what was expected.
    """
    try:
        data = read_file(path, _MAX_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise CalibrationError(f"{path} cannot be read: {reason}") from error
    if len(data) > _MAX_BYTES:
        raise CalibrationError(f"{path}: expected at most {_MAX_BYTES} bytes")
    try:
        return parse_calibration(yaml.load(data, TreeLoader))
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise CalibrationError(f"{path}: {' '.join(str(error).split())}") from error
    except CalibrationError as error:
        raise CalibrationError(f"{path}: {error}") from error


def save_calibration(path: Path, camera: str, calibration: Calibration) -> None:
    """Writes such a file, all or nothing; `camera` is its camera_name.

    Raises:
        CalibrationError: it cannot be written.
    """
    try:
        replace_file(path.resolve(), calibration_yaml(camera, calibration).encode())
    except OSError as error:
        raise CalibrationError(f"{path} cannot be written: {error.strerror}") from error


def calibration_yaml(camera: str, calibration: Calibration) -> str:
    """Returns the contents of such a file; `camera` is its camera_name."""
    document = {
        "image_width": calibration.width,
        "image_height": calibration.height,
        "camera_name": camera,
        "camera_matrix": _rows(3, 3, calibration.k),
        "distortion_model": calibration.model,
        "distortion_coefficients": _rows(1, len(calibration.d), calibration.d),
        "rectification_matrix": _rows(3, 3, calibration.r),
        "projection_matrix": _rows(3, 4, calibration.p),
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def parse_calibration(document: Any) -> Calibration:
    """Checks the contents of such a file.

    Raises:
        CalibrationError: they are no calibration; says what was expected.
    """
    try:
        return _calibration(document)
    except KeyError as error:
        raise CalibrationError(f"{error.args[0]} is missing") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise CalibrationError(str(error)) from error


def _calibration(document: Any) -> Calibration:
    if not isinstance(document, Mapping):
        raise TypeError("expected a mapping with image_width, camera_matrix and so on")
    model = document["distortion_model"]
    if model not in _MODELS:
        raise ValueError(f"distortion_model: expected one of {', '.join(_MODELS)}, found {model}")
    calibration = Calibration(
        _size(document, "image_width"),
        _size(document, "image_height"),
        model,
        _matrix(document, "distortion_coefficients", 1, _MODELS[model]),
        _matrix(document, "camera_matrix", 3, 3),
        _matrix(document, "rectification_matrix", 3, 3),
        _matrix(document, "projection_matrix", 3, 4),
    )
    for name, fx, fy in (
        ("camera_matrix", calibration.k[0], calibration.k[4]),
        ("projection_matrix", calibration.p[0], calibration.p[5]),
    ):
        if fx <= 0 or fy <= 0:
            raise ValueError(f"{name}: expected focal lengths above 0, found {fx} and {fy}")
    return calibration


def _size(document: Mapping[str, Any], key: str) -> int:
    value = document[key]
    if type(value) is not int or not 0 < value < 1 << 16:
        raise ValueError(f"{key}: expected pixels, found {value}")
    return value


def _matrix(document: Mapping[str, Any], key: str, rows: int, columns: int) -> tuple[float, ...]:
    matrix = document[key]
    if not isinstance(matrix, Mapping):
        raise TypeError(f"{key}: expected rows, cols and data, found {matrix}")
    size = (matrix["rows"], matrix["cols"], len(matrix["data"]))
    if size != (rows, columns, rows * columns):
        found = f"{size[0]}x{size[1]} with {size[2]}"
        raise ValueError(f"{key}: expected {rows}x{columns} numbers, found {found}")
    numbers = tuple(map(float, matrix["data"]))
    if not all(map(isfinite, numbers)):
        raise ValueError(f"{key}: expected finite numbers, found {numbers}")
    return numbers


def _rows(rows: int, columns: int, data: Sequence[float]) -> dict[str, object]:
    return {"rows": rows, "cols": columns, "data": list(data)}
