"""A camera with a fisheye lens that goes past a painted wall with a painted board before it."""

import functools
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from bags import Messages, write_bag
from camera_messages import camera_info, stamped, transform_of
from ml2_tools.evaluation.trajectory import Trajectory
from ml2_tools.geometry.pose import Pose
from trajectories import START_NS

PREFIX = "/magic_leap2"
CAMERA = "world_left"
FRAME = f"{CAMERA}_optical_frame"
IMAGE = f"{PREFIX}/{CAMERA}/image_raw"
SIZE = (320, 240)
MATRIX = np.array([[180.0, 0, 161], [0, 181, 118], [0, 0, 1]])
EQUIDISTANT = (0.03, -0.01, 0.004, -0.001)
PERIOD_NS = 33_333_333
COMPRESSED = f"{IMAGE}/compressed"
TYPES = {
    f"{PREFIX}/config": "std_msgs/msg/String",
    IMAGE: "sensor_msgs/msg/Image",
    f"{PREFIX}/{CAMERA}/camera_info": "sensor_msgs/msg/CameraInfo",
    f"{PREFIX}/{CAMERA}/metadata": "std_msgs/msg/String",
    "/tf": "tf2_msgs/msg/TFMessage",
}
# Half the painted width in m, of 4096 px.
_PAINTED_M = 8.0


def trajectory(count: int) -> Trajectory:
    """Returns a path to the right in an arc, up and down, looking about."""
    return [(START_NS + number * PERIOD_NS, _pose(number / 30)) for number in range(count)]


def images(count: int) -> Iterator[tuple[int, NDArray[np.uint8]]]:
    grid = np.stack(np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1])), axis=-1)
    pixels = grid.reshape(-1, 1, 2).astype(np.float64)
    flat = cv2.fisheye.undistortPoints(pixels, MATRIX, np.array(EQUIDISTANT)).reshape(-1, 2)
    rays = np.concatenate([flat, np.ones((len(flat), 1))], axis=1)
    paints = [_paint(seed) for seed in (1, 2)]
    for stamp_ns, pose in trajectory(count):
        yield stamp_ns, _rendered(pose, rays, paints)


def recording(
    folder: Path, count: int, images_dropped: tuple[int, ...] = (), *, is_compressed: bool = False
) -> Path:
    """Returns the receiver's recording, without these images."""
    types = {name: type for name, type in TYPES.items() if name != IMAGE or not is_compressed}
    if is_compressed:
        types[COMPRESSED] = "sensor_msgs/msg/CompressedImage"
    write_bag(folder, types, _messages(count, images_dropped, is_compressed))
    return folder


def jpeg(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return cv2.imencode(".jpg", pixels)[1].ravel().astype(np.uint8, copy=False)


def _messages(count: int, images_dropped: tuple[int, ...], is_compressed: bool) -> Messages:
    config = String(data='{"headset": "h", "session": "s", "streams": {}}')
    yield f"{PREFIX}/config", 0, serialize_message(config)
    poses = dict(trajectory(count))
    for number, (stamp_ns, pixels) in enumerate(images(count)):
        sec, nanosec = divmod(stamp_ns, 10**9)
        header, pose = stamped(FRAME, stamp_ns), poses[stamp_ns]
        place = transform_of(stamped("magicleap_world", stamp_ns), FRAME, pose[:3, 3], _turn(pose))
        info = camera_info(header, SIZE, "equidistant", EQUIDISTANT, MATRIX)
        metadata = {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_number": 100 + number}
        metadata["intrinsics"] = {
            "width": SIZE[0],
            "height": SIZE[1],
            "focal_length": [MATRIX[0, 0], MATRIX[1, 1]],
            "principal_point": [MATRIX[0, 2], MATRIX[1, 2]],
            "distortion_model": "equidistant",
            "distortion": EQUIDISTANT,
        }
        sent: dict[str, Any] = {
            "/tf": TFMessage(transforms=[place]),
            f"{PREFIX}/{CAMERA}/camera_info": info,
            f"{PREFIX}/{CAMERA}/metadata": String(data=json.dumps(metadata)),
        }
        if number not in images_dropped and is_compressed:
            format, data = "mono8; jpeg compressed mono8", jpeg(pixels).tobytes()
            sent[COMPRESSED] = CompressedImage(header=header, format=format, data=data)
        elif number not in images_dropped:
            image = Image(header=header, width=SIZE[0], height=SIZE[1], encoding="mono8")
            image.step, image.data = SIZE[0], pixels.tobytes()
            sent[IMAGE] = image
        yield from ((topic, stamp_ns, serialize_message(it)) for topic, it in sent.items())


def _turn(pose: Pose) -> tuple[float, ...]:
    """The quaternion of a pose."""
    vector = cv2.Rodrigues(pose[:3, :3])[0].ravel()
    angle = np.linalg.norm(vector)
    axis = vector / angle * np.sin(angle / 2) if angle else vector
    return (*map(float, axis), float(np.cos(angle / 2)))


def _pose(at_s: float) -> Pose:
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(np.array([0.05 * np.sin(3 * at_s), 0.2 * np.sin(at_s), 0.02]))[0]
    pose[:3, 3] = 0.9 * at_s - 0.8, 0.15 * np.sin(2 * at_s), 0.3 * np.cos(at_s)
    return pose


@functools.cache
def _paint(seed: int) -> NDArray[np.uint8]:
    random = np.random.default_rng(seed)
    levels = [random.integers(0, 255, (side, side)).astype(np.float32) for side in (64, 256, 512)]
    large = [cv2.resize(it, (4096, 4096), interpolation=cv2.INTER_CUBIC) for it in levels]
    paint: NDArray[np.uint8] = np.clip(np.mean(large, axis=0), 0, 255).astype(np.uint8)
    return paint


def _rendered(
    pose: Pose, rays: NDArray[np.float64], paints: list[NDArray[np.uint8]]
) -> NDArray[np.uint8]:
    directions, eye = rays @ pose[:3, :3].T, pose[:3, 3]
    seen = np.zeros(len(rays), np.uint8)
    for paint, z_m, half_m in zip(paints, (4.0, 2.5), (_PAINTED_M, 0.6), strict=True):
        met = eye + directions * ((z_m - eye[2]) / directions[:, 2])[:, None]
        at = ((met[:, :2] / _PAINTED_M + 1) * 2048).astype(np.float32).reshape(*SIZE[::-1], 2)
        colours = cv2.remap(paint, at, None, cv2.INTER_LINEAR).ravel()  # type: ignore[call-overload]
        is_hit = np.abs(met[:, :2]).max(axis=1) < half_m
        seen[is_hit] = colours[is_hit]
    return np.asarray(seen.reshape(SIZE[::-1]))
