"""Files of a configuration, and of a calibration as camera_calibration writes it."""

import json
from collections.abc import Mapping
from typing import Any

import yaml

from ml2_receiver.configuration.config import Config, parse_config

_RUNS_BY_DEFAULT = ("world_center", "other_sensors")
_RAW = {"world": "Grayscale", "eye": "Grayscale", "depth": "Depth32"}


def only(sections: str | Mapping[str, Mapping[str, Any]]) -> str:
    """Returns a file with which nothing runs but `sections`, such as "gaze: {enabled: true}".

    Cameras send raw images, unless they have a format. A test may append lines.
    """
    given = yaml.safe_load(f"{{{sections}}}") if isinstance(sections, str) else sections
    off = {it: {"enabled": False} for it in _RUNS_BY_DEFAULT}
    lines = ["/ml2_receiver:", "  ros__parameters:"]
    for section, values in {**off, **given}.items():
        format = _RAW.get(section.partition("_")[0])
        is_raw = format is not None and values.get("enabled", False)
        shown = {"format": format, **values} if is_raw else values
        lines.append(f"    {section}: {json.dumps(shown)}")
    return "\n".join([*lines, ""])


def only_config(sections: str | Mapping[str, Mapping[str, Any]]) -> Config:
    return parse_config(only(sections).encode())


DOCUMENT = {
    "image_width": 1016,
    "image_height": 1016,
    "camera_name": "world_left",
    "camera_matrix": {"rows": 3, "cols": 3, "data": [580.5, 0, 507, 0, 581, 508, 0, 0, 1]},
    "distortion_model": "equidistant",
    "distortion_coefficients": {"rows": 1, "cols": 4, "data": [0.1, -0.02, 3e-3, -4e-4]},
    "rectification_matrix": {"rows": 3, "cols": 3, "data": [1, 0, 0, 0, 1, 0, 0, 0, 1]},
    "projection_matrix": {
        "rows": 3,
        "cols": 4,
        "data": [400, 0, 500, 0, 0, 401, 501, 0, 0, 0, 1, 0],
    },
}


def calibration_yaml(**changes: object) -> str:
    """DOCUMENT with other values; None removes a key."""
    document = {**DOCUMENT, **changes}
    return yaml.safe_dump({key: value for key, value in document.items() if value is not None})
