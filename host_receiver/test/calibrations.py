"""A calibration file as camera_calibration writes it."""

import yaml

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
