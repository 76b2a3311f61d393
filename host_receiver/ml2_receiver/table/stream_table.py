"""The stream table: what the headset can send, under which names, types and conditions.

It is read from config/streams.yaml, which says what each field means. Everything here is
immutable and may be shared between threads.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from ..wire.json_body import Scalar

MESSAGE_TYPE = re.compile(r"[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*")
_CUSTOM_NAME = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
_MAX_NAME, _MAX_TYPE = 64, 128

# The keys of every camera section beside `enabled`; legal together when one of its modes has them.
CAMERA_KEYS = ("stream", "resolution_width", "resolution_height", "update_rate", "format")


@dataclass(frozen=True)
class Qos:
    """History depth of a RELIABLE, KEEP_LAST publisher; `durability` as in rmw_qos_profile_t."""

    depth: int
    durability: str = "volatile"


@dataclass(frozen=True)
class Lane:
    """The bounded queue in front of one connection; `priority` is "urgent" or "bulk"."""

    priority: str
    queue_frames: int
    when_full: str


class Condition(NamedTuple):
    """Holds where the values of a stream have `value` for `key`."""

    key: str
    value: Scalar

    def holds(self, values: Mapping[str, Scalar]) -> bool:
        return values.get(self.key) == self.value


@dataclass(frozen=True)
class Topic:
    """One topic of one stream.

    `name` is relative to the prefix ("world_left/image_raw") or global ("/tf"); `lane` is
    "sensors" or, on an image lane, the stream's id; `qos` is a key of StreamTable.qos; `when` is
    what CONFIGURE must say to switch the topic on, None when the stream always has it.
    """

    stream: str
    role: str
    name: str
    type: str
    lane: str
    qos: str
    encoding: str | None
    when: Condition | None
    frame: str

    def full_name(self, prefix: str) -> str:
        return self.name if self.name.startswith("/") else f"{prefix}/{self.name}"


@dataclass(frozen=True)
class CustomTopics:
    """The topics `<stream>/<name>` that the device names, `max_topics` per run of its app."""

    stream: str
    role: str
    lane: str
    qos: str
    max_topics: int

    def topic(self, name: str, type: str) -> Topic | None:
        """The row that such a topic has; None for a name or a type that ROS forbids."""
        folder, _, own = name.partition("/")
        is_name = folder == self.stream and len(own) <= _MAX_NAME and _CUSTOM_NAME.fullmatch(own)
        if not is_name or len(type) > _MAX_TYPE or not MESSAGE_TYPE.fullmatch(type):
            return None
        return Topic(
            self.stream, self.role, name, type, self.lane, self.qos, None, when=None, frame=""
        )


@dataclass(frozen=True)
class ReceiverTopic:
    """A topic the receiver publishes itself; `name` is relative to the prefix."""

    name: str
    type: str
    qos: str


@dataclass(frozen=True)
class Mode:
    """Combinations a camera stream can run in. Rates are in Hz, resolutions (width, height) in px.

    `delivers` maps a rate the device accepts to the one it then delivers.
    """

    stream: int
    formats: tuple[str, ...]
    rates: tuple[int, ...]
    resolutions: tuple[tuple[int, int], ...]
    delivers: Mapping[int, int]


@dataclass(frozen=True)
class Key:
    """One key of a section.

    `type` is "bool", "file", "integer", "number", "text" or "topic". `read_only`: it cannot change
    while the receiver runs.
    """

    name: str
    type: str
    default: Scalar
    doc: str
    allowed: tuple[Scalar, ...] = ()
    minimum: float | None = None
    read_only: bool = False


@dataclass(frozen=True)
class Section:
    """One section of config.yaml; `modes` is empty unless it is a camera."""

    id: str
    doc: str
    permissions: tuple[str, ...]
    modes: tuple[Mode, ...]
    keys: Mapping[str, Key]


@dataclass(frozen=True)
class Stream:
    """What is configured, accepted or refused as a whole.

    It runs when its section has all values of `when`; `when` is None for one that runs with any
    other. `values` are the dotted keys that travel to the headset, each named by its last word.
    `backends` are the interfaces of the device that can serve it, surest first, with the reason.
    """

    id: str
    section: str
    when: Mapping[str, Scalar] | None
    values: tuple[str, ...]
    backends: Mapping[str, str]
    topics: tuple[Topic, ...]
    frame: str
    body_frame: str | None


@dataclass(frozen=True)
class StreamTable:
    """All of it, in the order of the file.

    `image_lanes`: the streams with a lane of their own. `permissions`: Android's, each "dangerous",
    which the user must grant, or "normal".
    """

    streams: Mapping[str, Stream]
    sections: Mapping[str, Section]
    permissions: Mapping[str, str]
    qos: Mapping[str, Qos]
    lanes: Mapping[str, Lane]
    image_lanes: tuple[str, ...]
    custom_topics: CustomTopics
    receiver_topics: tuple[ReceiverTopic, ...]
    world_frame: str
    head_frame: str
