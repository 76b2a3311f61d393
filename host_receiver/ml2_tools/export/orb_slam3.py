"""Writes the files that ORB-SLAM3's programs for EuRoC need in addition to an EuRoC folder.

Format: version 1.0 of its settings, Examples/ in https://github.com/UZ-SLAMLab/ORB_SLAM3
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ml2_receiver.configuration.calibration import Calibration

from .asl_yaml import OpenCvMatrix, asl_yaml
from .kalibr import MountedImu, RigCamera, distortion

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


def settings(cameras: Sequence[RigCamera], rate_hz: int, imu: MountedImu | None) -> str:
    """Returns the settings for one camera or a stereo pair, and for the IMU if it is known.

    Raises:
        ExportError: ORB-SLAM3 has no model for a lens.
    """
    first = cameras[0].calibration
    is_fisheye = distortion(first)[0] == "equidistant"
    document: dict[str, Any] = {
        "File.version": "1.0",
        "Camera.type": "KannalaBrandt8" if is_fisheye else "PinHole",
        **_camera(1, first),
        "Camera.width": first.width,
        "Camera.height": first.height,
        "Camera.fps": rate_hz,
        "Camera.RGB": 0,
    }
    if len(cameras) == 2:
        between = np.linalg.inv(cameras[0].pose) @ cameras[1].pose
        document |= _camera(2, cameras[1].calibration)
        document |= {"Stereo.ThDepth": 40.0, "Stereo.T_c1_c2": OpenCvMatrix(between)}
        for number, camera in enumerate(cameras, start=1):
            document[f"Camera{number}.overlappingBegin"] = 0
            document[f"Camera{number}.overlappingEnd"] = camera.calibration.width - 1
    if imu is not None:
        document |= {
            "IMU.T_b_c1": OpenCvMatrix(np.linalg.inv(imu.mounting.pose) @ cameras[0].pose),
            "IMU.NoiseGyro": imu.noise.gyroscope_noise_density,
            "IMU.NoiseAcc": imu.noise.accelerometer_noise_density,
            "IMU.GyroWalk": imu.noise.gyroscope_random_walk,
            "IMU.AccWalk": imu.noise.accelerometer_random_walk,
            "IMU.Frequency": imu.rate_hz,
        }
    return asl_yaml(document | _ORB | _VIEWER)


def _camera(number: int, calibration: Calibration) -> dict[str, float]:
    model, coefficients, _ = distortion(calibration)
    k = calibration.k
    names = ("k1", "k2", "k3", "k4") if model == "equidistant" else ("k1", "k2", "p1", "p2")
    values = {"fx": k[0], "fy": k[4], "cx": k[2], "cy": k[5]}
    values |= zip(names, coefficients, strict=True)
    return {f"Camera{number}.{name}": it for name, it in values.items()}


def times(stamps_ns: Sequence[int]) -> str:
    """Returns the file of image times, which are the names of the images."""
    return "".join(f"{at_ns}\n" for at_ns in stamps_ns)
