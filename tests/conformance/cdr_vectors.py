"""The cases of vectors/cdr: every message type of the product, and the corners of CDR.

A case is {"type", "message", "size", "bytes"} with the fields of
the message under their ROS names. An array of bytes is {"pattern": "index mod 251", "length": N}.
What is no JSON number is "NaN", "Infinity" or "-Infinity". A message with pixels also has
"prefix_size", which says where these begin.
"""

import math
from collections.abc import Callable
from typing import Any

import cdr_types as ros
from case_files import text
from cdr_message import Message

NAN = math.nan

FRAMES = [
    f"{sensor}{suffix}_frame"
    for sensor in ["head", "world_center", "world_left", "world_right", "color", "depth"]
    for suffix in ["", "_optical"]
]

CASES: dict[str, tuple[str, Callable[[Message], None]]] = {
    "Time": ("builtin_interfaces/msg/Time", lambda m: ros.time(m, 1_700_000_000, 123_456_789)),
    "TimeLeast": ("builtin_interfaces/msg/Time", lambda m: ros.time(m, -(2**31), 0)),
    "TimeMost": ("builtin_interfaces/msg/Time", lambda m: ros.time(m, 2**31 - 1, 999_999_999)),
    "Header": ("std_msgs/msg/Header", lambda m: ros.header_fields(m, ros.OPTICAL)),
    "HeaderNoFrame": ("std_msgs/msg/Header", lambda m: ros.header_fields(m, "")),
    "String": ("std_msgs/msg/String", lambda m: m.string("data", '{"exposure_ns": 8000000}')),
    "StringEmpty": ("std_msgs/msg/String", lambda m: m.string("data", "")),
    "StringNonAscii": ("std_msgs/msg/String", lambda m: m.string("data", "aß€😀\r\n\t\u007f")),
    "StringLong": ("std_msgs/msg/String", lambda m: m.string("data", "0123456789" * 300)),
    "Vector3": ("geometry_msgs/msg/Vector3", lambda m: ros.xyz(m, 1.5, -2.25, 0.1)),
    "Vector3NotFinite": (
        "geometry_msgs/msg/Vector3",
        lambda m: ros.xyz(m, NAN, math.inf, -math.inf),
    ),
    "Vector3Extreme": ("geometry_msgs/msg/Vector3", lambda m: ros.xyz(m, -0.0, 5e-324, 1.7e308)),
    "Point": ("geometry_msgs/msg/Point", lambda m: ros.xyz(m, 1.5, -2.25, 0.1)),
    "Quaternion": (
        "geometry_msgs/msg/Quaternion",
        lambda m: ros.quaternion(m, 0.0, 0.0, 0.6, -0.8),
    ),
    "Pose": ("geometry_msgs/msg/Pose", lambda m: ros.pose(m, 1.5)),
    "PoseStamped": ("geometry_msgs/msg/PoseStamped", ros.pose_stamped),
    "PoseWithCovariance": ("geometry_msgs/msg/PoseWithCovariance", ros.pose_with_covariance),
    "PoseArray": ("geometry_msgs/msg/PoseArray", lambda m: ros.pose_array(m, [0.0, 1.5, -2.0])),
    "PoseArrayEmpty": ("geometry_msgs/msg/PoseArray", lambda m: ros.pose_array(m, [])),
    "Transform": ("geometry_msgs/msg/Transform", lambda m: ros.transform(m, 0.25)),
    "TransformStamped": (
        "geometry_msgs/msg/TransformStamped",
        lambda m: ros.transform_stamped(m, "magicleap_world", "head_frame"),
    ),
    "TransformStampedNonAscii": (
        "geometry_msgs/msg/TransformStamped",
        lambda m: ros.transform_stamped(m, "monde_éé", "頭"),
    ),
    "TFMessage": ("tf2_msgs/msg/TFMessage", lambda m: ros.tf_message(m, FRAMES)),
    "TFMessageOne": ("tf2_msgs/msg/TFMessage", lambda m: ros.tf_message(m, ["head_frame"])),
    "TFMessageEmpty": ("tf2_msgs/msg/TFMessage", lambda m: ros.tf_message(m, [])),
    "Image": ("sensor_msgs/msg/Image", lambda m: ros.image(m, "mono8", 64, 48, 64)),
    "ImageDepth": ("sensor_msgs/msg/Image", lambda m: ros.image(m, "32FC1", 17, 3, 68)),
    "ImagePaddedRows": ("sensor_msgs/msg/Image", lambda m: ros.image(m, "mono8", 5, 3, 8)),
    "ImageEmpty": ("sensor_msgs/msg/Image", lambda m: ros.image(m, "", 0, 0, 0)),
    "CompressedImage": ("sensor_msgs/msg/CompressedImage", lambda m: ros.compressed_image(m, 1021)),
    "CompressedImageEmpty": (
        "sensor_msgs/msg/CompressedImage",
        lambda m: ros.compressed_image(m, 0),
    ),
    "FFMPEGPacket": (
        "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
        lambda m: ros.ffmpeg_packet(m, 1021, 1_700_000_000_123_456, 1),
    ),
    "FFMPEGPacketEmpty": (
        "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
        lambda m: ros.ffmpeg_packet(m, 0, 2**63, 0),
    ),
    "CompressedVideo": (
        "foxglove_msgs/msg/CompressedVideo",
        lambda m: ros.compressed_video(m, 37),
    ),
    "CameraInfo": (
        "sensor_msgs/msg/CameraInfo",
        lambda m: ros.camera_info(m, "plumb_bob", [0.25, -0.125, 1e-4, -1e-4, 0.01]),
    ),
    "CameraInfoFisheye": (
        "sensor_msgs/msg/CameraInfo",
        lambda m: ros.camera_info(m, "equidistant", [0.1, -0.02, 0.003, -0.0004]),
    ),
    "CameraInfoNoDistortion": ("sensor_msgs/msg/CameraInfo", lambda m: ros.camera_info(m, "", [])),
    "RegionOfInterest": (
        "sensor_msgs/msg/RegionOfInterest",
        lambda m: ros.region_of_interest(m, do_rectify=True),
    ),
    "Imu": ("sensor_msgs/msg/Imu", lambda m: ros.imu(m, orientation_known=True)),
    "ImuNoOrientation": ("sensor_msgs/msg/Imu", lambda m: ros.imu(m, orientation_known=False)),
    "MagneticField": ("sensor_msgs/msg/MagneticField", ros.magnetic_field),
    "Illuminance": ("sensor_msgs/msg/Illuminance", lambda m: ros.illuminance(m, 312.75, 0.0)),
    "FluidPressure": ("sensor_msgs/msg/FluidPressure", ros.fluid_pressure),
    "BatteryState": (
        "sensor_msgs/msg/BatteryState",
        lambda m: ros.battery_state(
            m, [3.75, 31.5, -0.5, 2.25, 4.5, 5.0, 0.5], [3.75, 3.5, NAN], "compute_pack"
        ),
    ),
    "Joy": ("sensor_msgs/msg/Joy", lambda m: ros.joy(m, [1.0, -0.5, 0.25, 0.75], [1, 0, 1])),
    "JoyOfNothing": ("sensor_msgs/msg/Joy", lambda m: ros.joy(m, [], [])),
    "Detection3DArray": (
        "vision_msgs/msg/Detection3DArray",
        lambda m: ros.detections(m, ["tag36h11:7", "tag36h11:586"]),
    ),
    "Detection3DArrayEmpty": (
        "vision_msgs/msg/Detection3DArray",
        lambda m: ros.detections(m, []),
    ),
    "DiagnosticArray": (
        "diagnostic_msgs/msg/DiagnosticArray",
        lambda m: ros.diagnostics(m, {"name": "Büro", "uuid": ""}),
    ),
    "BatteryStateUnknown": (
        "sensor_msgs/msg/BatteryState",
        lambda m: ros.battery_state(m, [NAN] * 7, [], ""),
    ),
}


def files() -> dict[str, bytes]:
    cases: dict[str, Any] = {}
    for case, (ros_type, write) in CASES.items():
        message = Message(ros_type)
        write(message)
        cases[case] = message.vector()
    return {"messages.json": text(cases, "type size prefix_size")}
