"""Reads the data for the checks from a recording in one pass, without keeping images."""

from array import array
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ml2_receiver.errors import ProtocolError
from ml2_receiver.recording.message_definitions import DEFINITIONS
from ml2_receiver.topics.config_topic import ConfigText
from ml2_receiver.topics.plain_messages import decode_string
from ml2_receiver.topics.stamps import header_stamp_ns, stamp_reader

from ..bags.bag_reader import Bag
from ..bags.decoding import decoder
from ..images.size import compressed_size

type Stamps = NDArray[np.int64]

TRANSFORMS = "tf2_msgs/msg/TFMessage"
_STRING = "std_msgs/msg/String"
READ = {TRANSFORMS, _STRING, *DEFINITIONS}
_MOST_FRAMES = 1000


@dataclass
class TopicRecord:
    """The stamps and header values of one topic, in the order of its messages.

    Attributes:
        stamps, received: the stamp in ns and the time of recording in ns of each message.
        frames: the number of messages by the header's frame id.
        sizes: the number of messages by width and height of an image or camera_info.
        broken: the number of payloads that cannot be decoded.
        fault: the error message of the first broken payload.
        understood, foreign: the number of texts that are, and that are not, a headset's
            configuration or the metadata of a capture.
        promised_hz: the rate in the headset's configuration; None without one.
    """

    type: str
    stamps: array[int] = field(default_factory=lambda: array("q"))
    received: array[int] = field(default_factory=lambda: array("q"))
    frames: Counter[str] = field(default_factory=Counter)
    sizes: Counter[tuple[int, int]] = field(default_factory=Counter)
    messages: int = 0
    broken: int = 0
    fault: str = ""
    understood: int = 0
    foreign: int = 0
    promised_hz: float | None = None

    @property
    def stamps_ns(self) -> Stamps:
        return np.array(self.stamps, np.int64)

    @property
    def received_ns(self) -> Stamps:
        """The times at which the messages with these stamps were recorded."""
        return np.array(self.received, np.int64)


@dataclass
class Survey:
    """The data of a recording.

    Attributes:
        topics: by absolute name.
        transforms: the stamps in ns of each transform on /tf, by parent and child.
        static: parent and child of each transform on /tf_static.
    """

    topics: dict[str, TopicRecord]
    transforms: dict[tuple[str, str], array[int]] = field(default_factory=dict)
    static: set[tuple[str, str]] = field(default_factory=set)


def survey(bag: Bag, on_bytes: Callable[[int], None] = lambda _: None) -> Survey:
    """Reads all of the recording; calls `on_bytes` with the length of each payload.

    Raises:
        RecordingError: the file is broken before its end.
    """
    found = Survey({name: TopicRecord(type) for name, type in sorted(bag.types.items())})
    for message in bag.messages():
        topic = found.topics.setdefault(message.topic, TopicRecord(""))
        topic.messages += 1
        try:
            _take(found, message.topic, message.time_ns, message.payload)
        except ValueError as error:
            topic.broken += 1
            topic.fault = topic.fault or str(error)[:200]
        on_bytes(len(message.payload))
    for topic in found.topics.values():
        # Another node's topic may have such a name, and other texts.
        if topic.understood and topic.foreign:
            topic.broken += topic.foreign
            topic.fault = topic.fault or f"{topic.foreign} texts are not like the others"
    return found


def _take(found: Survey, name: str, time_ns: int, payload: bytes) -> None:
    topic = found.topics[name]
    if topic.type == _STRING:
        if name.endswith(("/config", "/metadata")):
            _take_text(found, name, time_ns, payload)
    elif topic.type == TRANSFORMS:
        is_static = name.endswith("_static")
        for stamp in _transforms(found, payload, is_static=is_static):
            if not is_static:
                _add_stamp(topic, stamp, time_ns)
    elif topic.type in DEFINITIONS:
        message = decoder(topic.type)(payload)
        _add_stamp(topic, stamp_reader(topic.type)(payload), time_ns)
        if len(topic.frames) < _MOST_FRAMES:
            topic.frames[getattr(message, "header", message).frame_id] += 1
        size = _size(message)
        if size is not None and len(topic.sizes) < _MOST_FRAMES:
            topic.sizes[size] += 1


def _take_text(found: Survey, name: str, time_ns: int, payload: bytes) -> None:
    topic, text = found.topics[name], decode_string(payload)
    try:
        if name.endswith("/config"):
            _take_promised_rates(found, text)
        else:
            _add_stamp(topic, stamp_reader(_STRING)(payload), time_ns)
        topic.understood += 1
    except (ValueError, ProtocolError):
        topic.foreign += 1


def _size(message: Any) -> tuple[int, int] | None:
    """Returns width and height of an image or a camera_info; None for other messages."""
    if hasattr(message, "format"):
        return compressed_size(message.format, message.data)
    return (message.width, message.height) if hasattr(message, "width") else None


def _add_stamp(topic: TopicRecord, stamp: int, time_ns: int) -> None:
    topic.stamps.append(stamp)
    topic.received.append(time_ns)


def _transforms(found: Survey, payload: bytes, *, is_static: bool) -> Iterator[int]:
    """Takes the transforms of a message; yields the first one's stamp as the message's stamp."""
    transforms = decoder(TRANSFORMS)(payload).transforms
    for number, it in enumerate(transforms):
        edge = it.header.frame_id, it.child_frame_id
        if is_static:
            found.static.add(edge)
        elif edge in found.transforms or len(found.transforms) < _MOST_FRAMES:
            found.transforms.setdefault(edge, array("q")).append(header_stamp_ns(it.header))
        if number == 0:
            yield header_stamp_ns(it.header)


def _take_promised_rates(found: Survey, text: bytes) -> None:
    for stream in ConfigText.parse(text).streams.values():
        rate = (stream.values or {}).get("update_rate")
        for entry in stream.topics:
            if isinstance(rate, int | float) and rate > 0 and entry.topic in found.topics:
                found.topics[entry.topic].promised_hz = float(rate)
