"""Injects faults of a broken pipeline into a recording."""

import json
import random
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rclpy.serialization import deserialize_message, serialize_message

from bags import write_bag
from ml2_receiver.topics.message_types import message_class
from ml2_tools.bags.bag_reader import BagReader

_NANOS = 1_000_000_000
_SEED = 1

# Changes a message of the camera, given the last word of its topic; returns None to drop it.
type Fault = Callable[[str, Any], Any | None]


def shifted(shift_ns: int, _: str, message: Any) -> Any:
    """Shifts the stamps of images, camera_info and metadata, but not of transforms."""
    if hasattr(message, "header"):
        _add(message.header.stamp, shift_ns)
        return message
    content = json.loads(message.data)
    nanos = content["stamp"]["sec"] * _NANOS + content["stamp"]["nanosec"] + shift_ns
    content["stamp"] = dict(zip(("sec", "nanosec"), divmod(nanos, _NANOS), strict=True))
    message.data = json.dumps(content)
    return message


def lossy(share: float, random_: random.Random, word: str, message: Any) -> Any | None:
    """Drops a share of the images."""
    return None if word == "image_raw" and random_.random() < share else message


def compressed(quality: int, word: str, message: Any) -> Any:
    """Compresses and decompresses images as JPEG."""
    if word == "image_raw":
        pixels = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
        _, jpeg = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
        message.data = cv2.imdecode(jpeg, cv2.IMREAD_GRAYSCALE).tobytes()
    return message


def mistaken_lens(word: str, message: Any) -> Any:
    """Declares the fisheye's coefficients to be plumb_bob's."""
    if word == "camera_info":
        message.distortion_model = "plumb_bob"
        message.d = [*message.d, 0.0][:5]
    elif word == "metadata":
        content = json.loads(message.data)
        lens = content["intrinsics"]
        lens |= {"distortion_model": "plumb_bob", "distortion": [*lens["distortion"], 0.0][:5]}
        message.data = json.dumps(content)
    return message


FAULTS: dict[str, Fault] = {
    "stamps 5 ms late": partial(shifted, 5_000_000),
    "stamps 20 ms late": partial(shifted, 20_000_000),
    "5 % of the images lost": partial(lossy, 0.05, random.Random(_SEED)),
    "JPEG of quality 50": partial(compressed, 50),
    "wrong distortion model": mistaken_lens,
}


def inject(fault: Fault, camera: str, bag: Path, out: Path) -> None:
    """Writes a copy of a recording with a fault in the camera's messages."""
    reader = BagReader(bag)
    write_bag(out, reader.types, _changed(fault, f"{reader.prefix}/{camera}/", reader))


def _changed(fault: Fault, prefix: str, reader: BagReader) -> Iterator[tuple[str, int, bytes]]:
    for it in reader.messages():
        if it.topic.startswith(prefix):
            message = deserialize_message(it.payload, message_class(reader.types[it.topic]))
            changed = fault(it.topic.removeprefix(prefix), message)
            if changed is not None:
                yield it.topic, it.time_ns, serialize_message(changed)
        else:
            yield it.topic, it.time_ns, it.payload


def _add(stamp: Any, shift_ns: int) -> None:
    stamp.sec, stamp.nanosec = divmod(stamp.sec * _NANOS + stamp.nanosec + shift_ns, _NANOS)
