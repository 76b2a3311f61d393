"""A recording of a scripted device, and the payloads it sent."""

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from compressed_images import FORMAT, compressed_depth
from fake_sink import FakeSink
from ml2_receiver.recording.bag_folder import make_folder
from ml2_receiver.recording.bag_topic import BagTopic
from ml2_receiver.recording.bag_writer import BagWriter
from ml2_receiver.recording.recorder import Recorder
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import ReceiverSettings
from ml2_receiver.session.streams import Request
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.topics.plain_messages import encode_string
from ml2_receiver.transport.access import Everybody
from ml2_receiver.transport.listener import listen
from mock_device import MockDevice
from ros_messages import compressed_image, header, mono_image, payload, transform
from scene import PATIENT

PREFIX = "/magic_leap2"
COUNT = 30
CONFIG = '{"headset": "h", "session": "s", "streams": {}}'
REQUEST: Request = {
    "world_left": {"stream": 0, "format": "Grayscale"},
    "battery": {},
    "tf": {"layout": "flat"},
}


def pixels(number: int) -> NDArray[np.uint8]:
    """Returns the random grey levels of an image."""
    return np.random.default_rng(number).integers(0, 256, (48, 64), np.uint8)


def image(number: int) -> bytes:
    """A mono8 Image of pixels(), stamped with its number of seconds."""
    return mono_image(header("world_left_optical_frame", number), pixels(number))


def jpeg(number: int) -> bytes:
    """A CompressedImage of pixels()."""
    data = cv2.imencode(".jpg", pixels(number))[1].ravel()
    format = "mono8; jpeg compressed mono8"
    return compressed_image(header("world_left_optical_frame", number), format, data)


def colour_jpeg(pixels: NDArray[np.uint8]) -> bytes:
    """A CompressedImage of blue, green and red."""
    data = cv2.imencode(".jpg", pixels)[1].ravel()
    return compressed_image(header("color_optical_frame", 0), "rgb8; jpeg compressed bgr8", data)


def millimetres(number: int) -> NDArray[np.uint16]:
    """Returns the random depth of an image."""
    return np.random.default_rng(number).integers(0, 5000, (6, 8)).astype(np.uint16)


def depth(number: int) -> bytes:
    """A CompressedImage of millimetres()."""
    return depth_of(millimetres(number), number)


def depth_of(millimetres: NDArray[np.uint16], number: int = 0) -> bytes:
    data = compressed_depth(millimetres)
    return compressed_image(header("depth_optical_frame", number), FORMAT, data)


def battery(number: int) -> bytes:
    return payload(
        "sensor_msgs/msg/BatteryState",
        header("head_frame", number),
        *(4.2, 30.0, 1.5, 0.5, 1.0, 1.0, 0.5, 2, 1, 2, True),
        np.array([4.1, 4.2], np.float32),
        np.array([], np.float32),
        "compute pack, Gürtel",
        "1",
    )


def tf(number: int) -> bytes:
    return transform(header("magicleap_world", number), "head_frame", (1.0, 2.0, 3.0))


SENT: dict[str, tuple[str, Callable[[int], bytes]]] = {
    "world_left/image_raw": ("sensor_msgs/msg/Image", image),
    "battery": ("sensor_msgs/msg/BatteryState", battery),
    "/tf": ("tf2_msgs/msg/TFMessage", tf),
}


# The topics of a device that compresses its images.
COMPRESSED: dict[str, tuple[str, Callable[[int], bytes]]] = {
    "world_left/image_raw/compressed": ("sensor_msgs/msg/CompressedImage", jpeg),
    "depth/image_raw/compressedDepth": ("sensor_msgs/msg/CompressedImage", depth),
}
COMPRESSED_REQUEST: Request = {
    "world_left": {"stream": 0, "format": "jpeg"},
    "depth": {"format": "depth16"},
}


def absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"{PREFIX}/{topic}"


def payloads(count: int) -> dict[str, list[bytes]]:
    """Returns the payloads that send() sends, by absolute topic name."""
    return {
        absolute(name): [make(number) for number in range(count)]
        for name, (_, make) in SENT.items()
    }


def send(device: MockDevice, count: int) -> None:
    announced = {topic.name for topic in device.device.announced}
    for number in range(count):
        for name, (_, make) in (SENT | COMPRESSED).items():
            if name in announced:
                device.publish(name, make(number))


def new_writer(folder: Path, *topics: BagTopic, **options: Any) -> BagWriter:
    """A writer into a new folder, without compression unless said otherwise."""
    make_folder(folder, is_overwriting=False)
    writer = BagWriter(folder, **{"compression": "none", **options})
    for topic in topics:
        writer.add_topic(topic)
    return writer


def record(folder: Path, count: int, compression: str = "none", request: Request = REQUEST) -> None:
    """A whole session of a device."""
    failures: list[str] = []
    writer = new_writer(folder, compression=compression)
    recorder = Recorder(writer, load_table(), PREFIX, failures.append)
    sink = FakeSink()
    server = Server(
        listen(("127.0.0.1", 0)),
        Everybody(),
        FanOut([sink, recorder]),
        request,
        ReceiverSettings("test", "test", limits=PATIENT),
    )
    server.start()
    try:
        with MockDevice(server.address, says_ping=True) as device:
            device.start()
            send(device, count)
            device.leave()
        sink.await_report()
    finally:
        server.stop()
        recorder.close()
    assert failures == []


def written(
    folder: Path,
    messages: list[tuple[str, int, bytes]],
    types: Mapping[str, str] = MappingProxyType({}),
    prefix: str = "/p",
) -> Path:
    """A recording of these topics, times in s and payloads, after the configuration of `prefix`.

    Args:
        types: of topics that are none of BatteryState.
    """
    table = load_table()
    config = BagTopic(f"{prefix}/config", "std_msgs/msg/String", table.qos["latched"])
    topics = {config.name: config}
    for name, _, _ in messages:
        type = types.get(name, "sensor_msgs/msg/BatteryState")
        topics[name] = BagTopic(name, type, table.qos["sensor"])
    writer = new_writer(folder, *topics.values())
    writer.write(config, 0, encode_string(CONFIG))
    for name, time_s, data in messages:
        writer.write(topics[name], time_s * 10**9, data)
    writer.close()
    return folder


def remove(folder: Path) -> None:
    """Removes the folder of a recording that goes on, and may make a file in it meanwhile."""
    while folder.exists():
        shutil.rmtree(folder, ignore_errors=True)
