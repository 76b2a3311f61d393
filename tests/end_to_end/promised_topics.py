"""The documented topics, written independently of the stream table.

Each map is topic below the prefix -> (type, frame id). Topics that exclude others have own maps.
"""

from __future__ import annotations

type Topics = dict[str, tuple[str, str]]


def _camera(topic: str, frame: str, image: str = "image_raw") -> Topics:
    type = "Image" if image == "image_raw" else "CompressedImage"
    return {
        f"{topic}/{image}": (f"sensor_msgs/msg/{type}", frame),
        f"{topic}/camera_info": ("sensor_msgs/msg/CameraInfo", frame),
        f"{topic}/metadata": ("std_msgs/msg/String", frame),
    }


def _eye(name: str) -> Topics:
    topics = _camera(f"eye_{name}", f"eye_{name}_optical_frame")
    del topics[f"eye_{name}/camera_info"]
    return topics


def _imu(place: str) -> Topics:
    frame = f"imu_{place}_frame"
    return {f"{it}_{place}/imu": ("sensor_msgs/msg/Imu", frame) for it in ("accel", "gyro", "imu")}


MIXED_REALITY = _camera("mixed_reality", "color_optical_frame", "image_raw/compressed")
INFRA = _camera("infra", "depth_optical_frame")
ALL_OTHERS: Topics = {
    **_camera("world_center", "world_center_optical_frame"),
    **_camera("world_left", "world_left_optical_frame"),
    **_camera("world_right", "world_right_optical_frame"),
    **_camera("color", "color_optical_frame", "image_raw/compressed"),
    **_camera("depth", "depth_optical_frame"),
    "depth/confidence": ("sensor_msgs/msg/Image", "depth_optical_frame"),
    "depth/flags": ("sensor_msgs/msg/Image", "depth_optical_frame"),
    **_eye("nasal_left"),
    **_eye("nasal_right"),
    **_eye("temple_left"),
    **_eye("temple_right"),
    **_imu("left"),
    **_imu("right"),
    **_imu("compute_pack"),
    "light_sensor": ("sensor_msgs/msg/Illuminance", "head_frame"),
    "head_pose": ("geometry_msgs/msg/PoseStamped", "magicleap_world"),
    "magnetometer_left": ("sensor_msgs/msg/MagneticField", "imu_left_frame"),
    "magnetometer_right": ("sensor_msgs/msg/MagneticField", "imu_right_frame"),
    "pressure_headset": ("sensor_msgs/msg/FluidPressure", "head_frame"),
    "pressure_compute_pack": ("sensor_msgs/msg/FluidPressure", "imu_compute_pack_frame"),
    "gaze": ("geometry_msgs/msg/PoseStamped", "magicleap_world"),
    "hand_left": ("geometry_msgs/msg/PoseArray", "magicleap_world"),
    "hand_right": ("geometry_msgs/msg/PoseArray", "magicleap_world"),
    "controller": ("geometry_msgs/msg/PoseStamped", "magicleap_world"),
    "controller/joy": ("sensor_msgs/msg/Joy", "controller_frame"),
    "map/state": ("diagnostic_msgs/msg/DiagnosticArray", "magicleap_map"),
    "battery": ("sensor_msgs/msg/BatteryState", "head_frame"),
    "markers": ("vision_msgs/msg/Detection3DArray", "magicleap_world"),
}
