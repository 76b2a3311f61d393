"""The stream table: the headset's streams, and the names, types and conditions of their topics.

It is read from config/streams.yaml, which explains each field. All objects are immutable and may be
shared between threads.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from ..wire.json_body import Scalar
from ..wire.kinds import CONTROL, LINK_TEST, PAIRING, ROS_LANES, TIME, Lane, LaneKind

MESSAGE_TYPE = re.compile(r"[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*")
SERVICE_TYPE = re.compile(r"[a-z][a-z0-9_]*/srv/[A-Z][A-Za-z0-9]*")
_CUSTOM_NAME = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
_ABSOLUTE_NAME = re.compile(r"(/[A-Za-z](_?[A-Za-z0-9])*)+")
_MAX_NAME, _MAX_TYPE, _MAX_ABSOLUTE = 64, 128, 255

# The keys of every camera section except `enabled`. Their values are legal if one mode has all.
CAMERA_KEYS = ("stream", "resolution_width", "resolution_height", "update_rate", "format")

# The formats whose images depend on those before them; their size is the key `bit_rate_mbit`.
VIDEO = ("h264", "h264_foxglove")


@dataclass(frozen=True)
class Qos:
    """History depth of a RELIABLE, KEEP_LAST publisher; `durability` as in rmw_qos_profile_t."""

    depth: int
    durability: str = "volatile"


@dataclass(frozen=True)
class LaneClass:
    """The common properties of the lanes of one purpose.

    A shared class is one lane with its name. Of another class, each stream with topics on it has a
    lane of its own, named by the stream's id. What is paced gives way to what is not.
    `queue_frames` is the length of the queue in front of a lane, whose oldest message is dropped
    when it is full.
    """

    name: str
    is_shared: bool
    is_paced: bool
    queue_frames: int
    max_payload_bytes: int

    def __post_init__(self) -> None:
        if self.name.upper() not in LaneKind.__members__:
            raise ValueError(f"the wire knows no lanes of the class {self.name}")

    def lane(self, stream: str) -> Lane:
        """Returns the lane of the topics of this class in a stream."""
        name = self.name if self.is_shared else stream
        kind = LaneKind[self.name.upper()]
        return Lane(name, kind, not self.is_paced, self.max_payload_bytes)


class Condition(NamedTuple):
    """A condition on a stream's values: that of `key` is `value`."""

    key: str
    value: Scalar

    def holds(self, values: Mapping[str, Scalar]) -> bool:
        return values.get(self.key) == self.value


@dataclass(frozen=True)
class Pace:
    """The rate at which a stream delivers.

    `rate_hz` is the nominal rate; None means the rate of a camera's mode, or as delivered.
    `longest_pause_s` is the longest normal pause between two samples; None means that any pause is
    normal.
    """

    rate_hz: int | None = None
    longest_pause_s: int | None = None

    def __post_init__(self) -> None:
        for name, value in (("rate_hz", self.rate_hz), ("longest_pause_s", self.longest_pause_s)):
            if value is not None and value <= 0:
                raise ValueError(f"{name}: expected a number above 0, found {value}")


@dataclass(frozen=True)
class Topic:
    """One topic of one stream.

    `name` is relative to the prefix ("world_left/image_raw") or global ("/tf"). `qos` is a key of
    StreamTable.qos. `when` is the condition on the values in CONFIGURE; None means that the stream
    always has the topic. `pace` is that of the stream, but a latched topic may be silent for any
    time.
    """

    stream: str
    role: str
    name: str
    type: str
    lane: Lane
    qos: str
    encoding: str | None
    when: Condition | None
    frame: str
    pace: Pace = Pace()

    def full_name(self, prefix: str) -> str:
        return self.name if self.name.startswith("/") else f"{prefix}/{self.name}"


@dataclass(frozen=True)
class CustomTopics:
    """The topics that the device names, `max_topics` per run of its app.

    They are `<stream>/<name>`, or absolute. Each has one of `lanes` and of `qos`, by default the
    first.
    """

    stream: str
    role: str
    lanes: tuple[Lane, ...]
    qos: tuple[str, ...]
    max_topics: int

    def topic(self, name: str, type: str, qos: str = "", lane: str = "") -> Topic | None:
        """Returns the row of a custom topic, or None if there can be none."""
        folder, _, own = name.partition("/")
        is_own = folder == self.stream and len(own) <= _MAX_NAME and _CUSTOM_NAME.fullmatch(own)
        is_absolute = len(name) <= _MAX_ABSOLUTE and _ABSOLUTE_NAME.fullmatch(name)
        if not (is_own or is_absolute) or len(type) > _MAX_TYPE or not MESSAGE_TYPE.fullmatch(type):
            return None
        by_name = {it.name: it for it in self.lanes}
        found = by_name.get(lane or self.lanes[0].name)
        if found is None or (qos := qos or self.qos[0]) not in self.qos:
            return None
        return Topic(self.stream, self.role, name, type, found, qos, None, when=None, frame="")


@dataclass(frozen=True)
class Adaptation:
    """The order in which images give way to the link.

    Each `quality` of JPEG is gone through first, with each of them one group of `streams` after
    another. Then group after group goes through each `rate_hz`, in a first round down to its
    `first_round_hz`, in a second one through the rest.
    """

    streams: tuple[tuple[str, ...], ...]
    quality: tuple[int, ...]
    rate_hz: tuple[int, ...]
    first_round_hz: tuple[int, ...]


@dataclass(frozen=True)
class ImageSizes:
    """The sizes of images, for forecasts.

    `bits_per_pixel` is by format, without VIDEO, that of JPEG at quality 80. `jpeg_by_quality` is
    the size of a JPEG relative to that at 80, for some qualities from 1 to 100.
    """

    bits_per_pixel: Mapping[str, float]
    jpeg_by_quality: Mapping[int, float]


@dataclass(frozen=True)
class ReceiverTopic:
    """A topic the receiver publishes itself; `name` is relative to the prefix."""

    name: str
    type: str
    qos: str


@dataclass(frozen=True)
class Mode:
    """Combinations a camera stream can run in; rates in Hz, resolutions (width, height) in px."""

    stream: int
    formats: tuple[str, ...]
    rates: tuple[int, ...]
    resolutions: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Key:
    """One key of a section.

    `type` is "bool", "file", "integer", "line", "link", "names", "number", "text" or "topic". A
    number lies between `minimum` and `maximum`. Names are a list in files, or one text with spaces
    between them; it is a text for ROS, whose files have no empty lists. A `read_only` key cannot
    change while the receiver runs.
    """

    name: str
    type: str
    default: Scalar
    doc: str
    allowed: tuple[Scalar, ...] = ()
    minimum: float | None = None
    maximum: float | None = None
    read_only: bool = False


@dataclass(frozen=True)
class Section:
    """One section of config.yaml.

    A stream of a section with `modes` runs in one of them. `shows_eyes` says that its images are of
    the wearer's eyes, which are biometric data.
    """

    id: str
    doc: str
    permissions: tuple[str, ...]
    shows_eyes: bool
    modes: tuple[Mode, ...]
    keys: Mapping[str, Key]


@dataclass(frozen=True)
class Stream:
    """A group of topics that is configured, accepted or refused as a whole.

    The stream runs if each key of `when` has one of its values in its section; None means that it
    runs with any other stream. `values` are the dotted keys that are sent to the headset, under
    their last word. `backends` maps the interfaces of the device that can serve the stream, the
    most reliable first, to the reason.
    """

    id: str
    section: str
    when: Mapping[str, tuple[Scalar, ...]] | None
    values: tuple[str, ...]
    backends: Mapping[str, str]
    topics: tuple[Topic, ...]
    frame: str
    body_frame: str | None
    pace: Pace

    @property
    def images(self) -> tuple[Topic, ...]:
        """The topics with images, which only cameras have."""
        return tuple(topic for topic in self.topics if topic.lane.kind is LaneKind.IMAGE)


@dataclass(frozen=True)
class StreamTable:
    """The whole table, in the order of the file.

    `lanes` are those that carry DATA, by name. `permissions` maps each Android permission to
    "dangerous" (the user must grant it) or "normal".
    """

    streams: Mapping[str, Stream]
    sections: Mapping[str, Section]
    permissions: Mapping[str, str]
    qos: Mapping[str, Qos]
    lane_classes: Mapping[str, LaneClass]
    lanes: Mapping[str, Lane]
    adaptation: Adaptation
    image_sizes: ImageSizes
    custom_topics: CustomTopics
    receiver_topics: tuple[ReceiverTopic, ...]
    world_frame: str
    head_frame: str

    def lane(self, name: str) -> Lane:
        """Returns the lane with this name, which has to be one of PROTOCOL.md."""
        return self.lanes[name] if name in self.lanes else _LANES_WITHOUT_DATA[name]

    @property
    def needed_lanes(self) -> tuple[str, ...]:
        """The lanes that every session has besides control, from its beginning on."""
        return (TIME.name, *(it.name for it in self.lane_classes.values() if it.is_shared))

    def shows_eyes(self, stream: str) -> bool:
        """Returns True if the images of a stream are of the wearer's eyes."""
        return self.sections[self.streams[stream].section].shows_eyes


_LANES_WITHOUT_DATA = {lane.name: lane for lane in (CONTROL, TIME, LINK_TEST, PAIRING, *ROS_LANES)}
