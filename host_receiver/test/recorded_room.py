"""A recording in many chunks, written by the library of MCAP: grey images that tell their time."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.writer import Writer

import ros_messages
from bag_scene import battery
from ml2_receiver.topics.plain_messages import encode_string

PREFIX = "/robot1/magic_leap2"
IMAGE = "sensor_msgs/msg/Image"
WORLD, EYE = f"{PREFIX}/world_left/image_raw", f"{PREFIX}/eye_nasal_left/image_raw"
BATTERY, CONFIG, STATIC = f"{PREFIX}/battery", f"{PREFIX}/config", "/tf_static"
TYPE_OF = {
    WORLD: IMAGE,
    EYE: IMAGE,
    BATTERY: "sensor_msgs/msg/BatteryState",
    CONFIG: "std_msgs/msg/String",
    STATIC: "tf2_msgs/msg/TFMessage",
    "/tf": "tf2_msgs/msg/TFMessage",
}
HZ = 10
LENGTH_S = 20
# The eye camera starts late and stops early.
EYE_S = 1, 5
BEGIN_NS = 1_700_000_000 * 10**9
_CHUNK_BYTES = 16 << 10


class Recorded(NamedTuple):
    topic: str
    time_ns: int
    payload: bytes


def grey(number: int) -> int:
    """The level of all pixels of an image; JPEG keeps a flat one within 2."""
    return 20 + number


def time_ns(number: int) -> int:
    """The time of recording of an image."""
    return BEGIN_NS + number * 10**9 // HZ


def messages() -> Iterator[Recorded]:
    """Yields all messages in the order of their times."""
    yield Recorded(CONFIG, BEGIN_NS, encode_string(_CONFIG))
    yield Recorded(STATIC, BEGIN_NS, transform("head_frame", "mount", 0))
    yield Recorded(BATTERY, BEGIN_NS, battery(0))
    for number in range(LENGTH_S * HZ + 1):
        yield Recorded("/tf", time_ns(number), transform("magicleap_world", "head_frame", number))
        yield Recorded(WORLD, time_ns(number), image(number))
        if EYE_S[0] * HZ <= number <= EYE_S[1] * HZ:
            yield Recorded(EYE, time_ns(number), image(number))


def image(number: int) -> bytes:
    header = ros_messages.header("robot1/world_left_optical_frame", 7)
    return ros_messages.mono_image(header, np.full((48, 64), grey(number), np.uint8))


def transform(parent: str, child: str, metres: float) -> bytes:
    """One along the x axis."""
    header = ros_messages.header(f"robot1/{parent}", 7)
    return ros_messages.transform(header, f"robot1/{child}", (metres, 0.0, 0.0))


def write(folder: Path, *, is_finished: bool = True) -> Path:
    """Writes the recording; an unfinished one has neither an index nor its last chunk."""
    folder.mkdir()
    with (folder / "room_0.mcap").open("wb") as file:
        writer = Writer(file, chunk_size=_CHUNK_BYTES)
        writer.start("ros2", "test")
        schemas = {it: writer.register_schema(it, "ros2msg", b"") for it in TYPE_OF.values()}
        channels = {
            topic: writer.register_channel(topic, "cdr", schemas[type])
            for topic, type in TYPE_OF.items()
        }
        for it in messages():
            writer.add_message(channels[it.topic], it.time_ns, it.payload, it.time_ns)
        if is_finished:
            writer.finish()
    return folder


def write_damaged(folder: Path) -> Path:
    """Writes the recording, and changes a byte in the middle."""
    (file,) = write(folder).glob("*.mcap")
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 0xFF
    file.write_bytes(data)
    return folder


_CONFIG = """{"headset": "device name", "session": "s", "streams": {"world_left": {
  "result": "applied", "reason": null, "topics": [], "values": {"resolution_width": 1016,
  "resolution_height": 1016, "update_rate": 30, "format": "Grayscale"}}}}"""
