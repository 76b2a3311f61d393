"""Writes settings for OpenVINS, which subscribes to `ml2-receiver run` or to a played bag.

Format: https://docs.openvins.com, config/ in https://github.com/rpng/open_vins
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .asl_yaml import asl_yaml
from .kalibr import GRAVITY, ImuNoise, Mounting, RigCamera, distortion

IMU_CHAIN, CAMERA_CHAIN = "kalibr_imu_chain.yaml", "kalibr_imucam_chain.yaml"
_IDENTITY_3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
_IDENTITY_4 = [[float(row == column) for column in range(4)] for row in range(4)]
# OpenVINS requires these values; they are those of its examples. A head moves at the start, so the
# dynamic initialization is on.
_INITIALIZATION = {
    "init_window_time": 2.0,
    "init_imu_thresh": 1.5,
    "init_max_disparity": 10.0,
    "init_max_features": 50,
    "init_dyn_use": True,
    "init_dyn_mle_opt_calib": False,
    "init_dyn_mle_max_iter": 50,
    "init_dyn_mle_max_time": 0.05,
    "init_dyn_mle_max_threads": 6,
    "init_dyn_num_pose": 6,
    "init_dyn_min_deg": 10.0,
    "init_dyn_inflation_ori": 10,
    "init_dyn_inflation_vel": 100,
    "init_dyn_inflation_bg": 10,
    "init_dyn_inflation_ba": 100,
    "init_dyn_min_rec_cond": 1e-12,
    "init_dyn_bias_g": [0.0, 0.0, 0.0],
    "init_dyn_bias_a": [0.0, 0.0, 0.0],
}
_FILTER = {
    "use_fej": True,
    "integration": "rk4",
    "calib_cam_extrinsics": True,
    "calib_cam_intrinsics": False,
    "calib_cam_timeoffset": True,
    "calib_imu_intrinsics": False,
    "calib_imu_g_sensitivity": False,
    "max_clones": 11,
    "max_slam": 50,
    "max_slam_in_update": 25,
    "max_msckf_in_update": 40,
    "dt_slam_delay": 1,
    "gravity_mag": GRAVITY,
    "feat_rep_msckf": "GLOBAL_3D",
    "feat_rep_slam": "ANCHORED_MSCKF_INVERSE_DEPTH",
    "feat_rep_aruco": "ANCHORED_MSCKF_INVERSE_DEPTH",
    # The parser wants the values of zero-velocity updates although there are none.
    "try_zupt": False,
    "zupt_chi2_multipler": 0,
    "zupt_max_velocity": 0.1,
    "zupt_noise_multiplier": 10,
    "zupt_max_disparity": 0.5,
    "zupt_only_at_beginning": False,
}
_FRONT_END = {
    "use_klt": True,
    "num_pts": 200,
    "fast_threshold": 20,
    "grid_x": 5,
    "grid_y": 5,
    "min_px_dist": 10,
    "knn_ratio": 0.70,
    "track_frequency": 31.0,
    "downsample_cameras": False,
    "num_opencv_threads": 4,
    "histogram_method": "HISTOGRAM",
    "use_aruco": False,
    "num_aruco": 1024,
    "downsize_aruco": True,
    "up_msckf_sigma_px": 1,
    "up_msckf_chi2_multipler": 1,
    "up_slam_sigma_px": 1,
    "up_slam_chi2_multipler": 1,
    "up_aruco_sigma_px": 1,
    "up_aruco_chi2_multipler": 1,
    "use_mask": False,
}


def estimator_config(cameras: int) -> str:
    """Returns the text of estimator_config.yaml, for one camera, or for two as a stereo pair.

    Its cameras are in CAMERA_CHAIN. OpenVINS then writes its states to a file for
    `evaluate --trajectory`.
    """
    used = {"use_stereo": cameras == 2, "max_cameras": cameras}
    document: dict[str, Any] = {"verbosity": "INFO", **_FILTER, **used, **_INITIALIZATION}
    document |= {
        "record_timing_information": False,
        "record_timing_filepath": "timing.txt",
        "save_total_state": True,
        "filepath_est": "open_vins_state.txt",
        "filepath_std": "open_vins_deviation.txt",
        "filepath_gt": "open_vins_truth.txt",
    }
    chains = {"relative_config_imu": IMU_CHAIN, "relative_config_imucam": CAMERA_CHAIN}
    return asl_yaml(document | _FRONT_END | chains)


def camera_chain(cameras: Sequence[RigCamera], mounting: Mounting) -> str:
    """Returns the text of kalibr_imucam_chain.yaml.

    OpenVINS refines the time offset.

    Raises:
        ExportError: OpenVINS has no model for a lens.
    """
    chain: dict[str, Any] = {}
    for number, camera in enumerate(cameras):
        k = camera.calibration.k
        model, coefficients, _ = distortion(camera.calibration)
        chain[f"cam{number}"] = {
            "T_imu_cam": (np.linalg.inv(mounting.pose) @ camera.pose).tolist(),
            "cam_overlaps": [other for other in range(len(cameras)) if other != number],
            "camera_model": "pinhole",
            "distortion_coeffs": coefficients,
            "distortion_model": model,
            "intrinsics": [k[0], k[4], k[2], k[5]],
            "resolution": [camera.calibration.width, camera.calibration.height],
            "rostopic": camera.topic,
            "timeshift_cam_imu": mounting.time_offset_s,
        }
    return asl_yaml(chain)


def imu_chain(topic: str, rate_hz: float, noise: ImuNoise) -> str:
    """Returns the text of kalibr_imu_chain.yaml, for an IMU without scale, skew or misalignment."""
    unit: dict[str, Any] = {"T_i_b": _IDENTITY_4, **vars(noise), "rostopic": topic}
    unit |= {"time_offset": 0.0, "update_rate": round(rate_hz, 2), "model": "kalibr"}
    unit |= dict.fromkeys(("Tw", "R_IMUtoGYRO", "Ta", "R_IMUtoACC"), _IDENTITY_3)
    unit["Tg"] = [[0.0] * 3] * 3
    return asl_yaml({"imu0": unit})
