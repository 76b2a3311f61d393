"""Writes the files that ORB-SLAM3's program `mono_euroc` needs in addition to an EuRoC folder.

Format: version 1.0 of its settings, Examples/Monocular in https://github.com/UZ-SLAMLab/ORB_SLAM3
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ml2_receiver.configuration.calibration import Calibration

from .asl_yaml import asl_yaml
from .kalibr import distortion

# The values of ORB-SLAM3's examples, with more features for the larger images of 1016 x 1016.
_ORB = {
    "ORBextractor.nFeatures": 1500,
    "ORBextractor.scaleFactor": 1.2,
    "ORBextractor.nLevels": 8,
    "ORBextractor.iniThFAST": 20,
    "ORBextractor.minThFAST": 7,
}
_VIEWER = {
    "Viewer.KeyFrameSize": 0.05,
    "Viewer.KeyFrameLineWidth": 1.0,
    "Viewer.GraphLineWidth": 0.9,
    "Viewer.PointSize": 2.0,
    "Viewer.CameraSize": 0.08,
    "Viewer.CameraLineWidth": 3.0,
    "Viewer.ViewpointX": 0.0,
    "Viewer.ViewpointY": -0.7,
    "Viewer.ViewpointZ": -3.5,
    "Viewer.ViewpointF": 500.0,
}


def settings(camera: Calibration, rate_hz: int) -> str:
    """Returns the settings for one camera.

    Raises:
        ExportError: ORB-SLAM3 has no model for the lens.
    """
    model, coefficients, _ = distortion(camera)
    is_fisheye = model == "equidistant"
    names = ("k1", "k2", "k3", "k4") if is_fisheye else ("k1", "k2", "p1", "p2")
    document: dict[str, Any] = {
        "File.version": "1.0",
        "Camera.type": "KannalaBrandt8" if is_fisheye else "PinHole",
        "Camera1.fx": camera.k[0],
        "Camera1.fy": camera.k[4],
        "Camera1.cx": camera.k[2],
        "Camera1.cy": camera.k[5],
        **{f"Camera1.{name}": it for name, it in zip(names, coefficients, strict=True)},
        "Camera.width": camera.width,
        "Camera.height": camera.height,
        "Camera.fps": rate_hz,
        "Camera.RGB": 0,
    }
    return asl_yaml(document | _ORB | _VIEWER)


def times(stamps_ns: Sequence[int]) -> str:
    """Returns the file of image times, which are the names of the images."""
    return "".join(f"{at_ns}\n" for at_ns in stamps_ns)
