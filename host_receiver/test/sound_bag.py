"""A recording in which all is well, for tests to damage before rosbags writes it."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import ros_messages
from bags import write_bag
from compressed_images import FORMAT, compressed_depth

PREFIX = "/magic_leap2"
IMAGES, INFOS = f"{PREFIX}/world_left/image_raw", f"{PREFIX}/world_left/camera_info"
METADATA, IMU = f"{PREFIX}/world_left/metadata", f"{PREFIX}/imu_left/imu"
FRAME, WORLD = "world_left_optical_frame", "magicleap_world"
WIDTH, HEIGHT = 8, 6
K, D = (5.0, 0.0, 3.5, 0.0, 5.5, 2.5, 0.0, 0.0, 1.0), (0.1, -0.02, 3e-3, -4e-4)
TURN_RATE, ACCELERATION = (0.1, -0.2, 0.3), (1.0, 9.8, -2.0)
SECOND_NS = 1_000_000_000
BEGIN_NS = 1_700_000_000 * SECOND_NS
LATENCY_NS = 10_000_000
DURATION_S = 3
CAMERA_HZ, IMU_HZ, TF_HZ = 30, 200, 60


@dataclass
class Message:
    """One that is not encoded yet; `stamp_ns` is that of the capture."""

    topic: str
    stamp_ns: int
    log_ns: int
    type: str
    frame: str = FRAME
    size: tuple[int, int] = (WIDTH, HEIGHT)
    position: tuple[float, float, float] = (1.0, 2.0, 3.0)
    parent: str = WORLD
    payload: bytes | None = None

    def encoded(self) -> bytes:
        """`payload` if there is one."""
        if self.payload is not None:
            return self.payload
        return _MAKE[self.type](self)


def sound() -> list[Message]:
    """Three seconds of a camera, an IMU and the camera's transforms, in the order of the stamps."""
    camera = [("sensor_msgs/msg/Image", IMAGES), ("sensor_msgs/msg/CameraInfo", INFOS)]
    camera += [("std_msgs/msg/String", METADATA), ("tf2_msgs/msg/TFMessage", "/tf")]
    messages = [
        _at(stamp_ns, topic, type) for type, topic in camera for stamp_ns in _times(CAMERA_HZ)
    ]
    messages += [_at(it, IMU, "sensor_msgs/msg/Imu") for it in _times(IMU_HZ)]
    taken = {it.stamp_ns for it in messages if it.topic == "/tf"}
    heads = [it for it in _times(TF_HZ) if it not in taken]
    messages += [_at(it, "/tf", "tf2_msgs/msg/TFMessage") for it in heads]
    return sorted(messages, key=lambda it: it.stamp_ns)


def pixels(it: Message) -> NDArray[np.uint8]:
    """Height x width, other ones for each stamp."""
    return np.random.default_rng(it.stamp_ns).integers(0, 256, it.size[::-1], np.uint8)


def written(folder: Path, messages: list[Message]) -> Path:
    """A rosbag2 folder of these, in the order of their log times."""
    in_order = sorted(messages, key=lambda it: it.log_ns)
    types = {it.topic: it.type for it in in_order}
    write_bag(folder, types, ((it.topic, it.log_ns, it.encoded()) for it in in_order))
    return folder


def config() -> Message:
    """Returns the configuration message at the start of a recording."""
    text = '{"headset": "h", "session": "s", "streams": {}, "device_id": "one"}'
    payload = ros_messages.string(text)
    return Message(f"{PREFIX}/config", 0, BEGIN_NS, "std_msgs/msg/String", payload=payload)


def second_camera(messages: list[Message], position: tuple[float, float, float]) -> list[Message]:
    """world_right beside world_left: the same stamps, another place."""
    return [
        replace(
            it,
            topic=it.topic.replace("world_left", "world_right"),
            frame="world_right_optical_frame",
            position=position,
        )
        for it in messages
        if it.frame == FRAME and it.type != "sensor_msgs/msg/Imu"
    ]


def compressed(messages: list[Message], camera: str = "world_left") -> list[Message]:
    """The same of this camera, whose headset compresses: as RVL if it is depth, else as JPEG."""
    transport = "compressedDepth" if camera == "depth" else "compressed"
    found = []
    for it in messages:
        topic, type = it.topic.replace("world_left", camera), it.type
        if it.topic == IMAGES:
            topic, type = f"{topic}/{transport}", "sensor_msgs/msg/CompressedImage"
        found.append(
            replace(it, topic=topic, type=type, frame=it.frame.replace("world_left", camera))
        )
    return found


def _times(rate_hz: int) -> Iterator[int]:
    return (BEGIN_NS + n * SECOND_NS // rate_hz for n in range(DURATION_S * rate_hz))


def _at(stamp_ns: int, topic: str, type: str) -> Message:
    return Message(topic, stamp_ns, stamp_ns + LATENCY_NS, type)


def _header(it: Message) -> Any:
    return ros_messages.header(it.frame, *divmod(it.stamp_ns, SECOND_NS))


def _image(it: Message) -> bytes:
    return ros_messages.mono_image(_header(it), pixels(it))


def _compressed(it: Message) -> bytes:
    format, data = "mono8; jpeg compressed mono8", cv2.imencode(".jpg", pixels(it))[1].tobytes()
    if it.topic.endswith("compressedDepth"):
        format, data = FORMAT, compressed_depth(pixels(it).astype(np.uint16))
    return ros_messages.compressed_image(_header(it), format, data)


def _info(it: Message) -> bytes:
    width, height = it.size
    region = ros_messages.message("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
    r, p = np.eye(3).ravel(), np.hstack([np.array(K).reshape(3, 3), np.zeros((3, 1))]).ravel()
    lens = ("equidistant", np.array(D), np.array(K), r, p, 0, 0, region)
    return ros_messages.payload("sensor_msgs/msg/CameraInfo", _header(it), height, width, *lens)


def _metadata(it: Message) -> bytes:
    sec, nanosec = divmod(it.stamp_ns, SECOND_NS)
    stamp = {"sec": sec, "nanosec": nanosec}
    return ros_messages.string(json.dumps({"stamp": stamp, "frame_id": it.frame}))


def _imu(it: Message) -> bytes:
    return ros_messages.imu(_header(it), TURN_RATE, ACCELERATION)


def _transforms(it: Message) -> bytes:
    header = ros_messages.header(it.parent, *divmod(it.stamp_ns, SECOND_NS))
    return ros_messages.transform(header, it.frame, it.position)


_MAKE = {
    "sensor_msgs/msg/Image": _image,
    "sensor_msgs/msg/CompressedImage": _compressed,
    "sensor_msgs/msg/CameraInfo": _info,
    "std_msgs/msg/String": _metadata,
    "sensor_msgs/msg/Imu": _imu,
    "tf2_msgs/msg/TFMessage": _transforms,
}
