"""Writes settings for VINS-Fusion, which subscribes to `ml2-receiver run` or to a played bag.

Format: config/ in https://github.com/HKUST-Aerial-Robotics/VINS-Fusion
"""

from collections.abc import Sequence
from math import sqrt
from typing import Any

import numpy as np

from ml2_receiver.configuration.calibration import Calibration

from .asl_yaml import OpenCvMatrix, asl_yaml
from .kalibr import GRAVITY, MountedImu, RigCamera, distortion

_SETTINGS = "vins_fusion.yaml"
# The values of its examples, with more features for the larger images.
_TRACKER: dict[str, Any] = {
    "multiple_thread": 1,
    "max_cnt": 200,
    "min_dist": 30,
    "freq": 0,  # that of the images
    "F_threshold": 1.0,
    "show_track": 1,
    "flow_back": 1,
    "max_solver_time": 0.04,
    "max_num_iterations": 8,
    "keyframe_parallax": 10.0,
    "estimate_td": 1,
    "load_previous_pose_graph": 0,
    "pose_graph_save_path": "vins_output/pose_graph/",
    "save_image": 0,
    "output_path": "vins_output/",
}


def files(cameras: Sequence[RigCamera], imu: MountedImu) -> dict[str, str]:
    """Returns the texts of the settings and of each camera, by file, for one or two cameras.

    Raises:
        ExportError: VINS-Fusion has no model for a lens.
    """
    size = cameras[0].calibration
    # It integrates samples, so its noise is that of one sample, not a density.
    rate, noise = sqrt(imu.rate_hz), imu.noise
    document: dict[str, Any] = {
        "imu": 1,
        "num_of_cam": len(cameras),
        "imu_topic": imu.topic,
        "image_width": size.width,
        "image_height": size.height,
        "estimate_extrinsic": 1,
        "acc_n": noise.accelerometer_noise_density * rate,
        "gyr_n": noise.gyroscope_noise_density * rate,
        "acc_w": noise.accelerometer_random_walk * rate,
        "gyr_w": noise.gyroscope_random_walk * rate,
        "g_norm": GRAVITY,
        "td": imu.mounting.time_offset_s,
    }
    texts = {}
    for number, camera in enumerate(cameras):
        name = f"vins_fusion_cam{number}.yaml"
        document |= {
            f"image{number}_topic": camera.topic,
            f"cam{number}_calib": name,
            f"body_T_cam{number}": OpenCvMatrix(np.linalg.inv(imu.mounting.pose) @ camera.pose),
        }
        texts[name] = _camera(camera.calibration)
    return {_SETTINGS: asl_yaml(document | _TRACKER), **texts}


def _camera(calibration: Calibration) -> str:
    model, coefficients, _ = distortion(calibration)
    k = calibration.k
    size = {
        "camera_name": "camera",
        "image_width": calibration.width,
        "image_height": calibration.height,
    }
    if model == "equidistant":  # its k2 is the coefficient of the third power, as OpenCV's k1
        of_lens = dict(zip(("k2", "k3", "k4", "k5"), coefficients, strict=True))
        centre = {"mu": k[0], "mv": k[4], "u0": k[2], "v0": k[5]}
        lens = {"model_type": "KANNALA_BRANDT", "projection_parameters": of_lens | centre}
        return asl_yaml(lens | size)
    lens = {
        "model_type": "PINHOLE",
        "distortion_parameters": dict(zip(("k1", "k2", "p1", "p2"), coefficients, strict=True)),
        "projection_parameters": {"fx": k[0], "fy": k[4], "cx": k[2], "cy": k[5]},
    }
    return asl_yaml(lens | size)
