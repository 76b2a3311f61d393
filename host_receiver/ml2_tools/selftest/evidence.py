"""Reads from recordings what judgements need. Images of eyes are never decoded."""

import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ml2_receiver.errors import ProtocolError
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import StreamTable
from ml2_receiver.topics.config_topic import ConfigText
from ml2_receiver.topics.plain_messages import decode_string
from ml2_receiver.topics.stamps import header_stamp_ns, stamp_reader
from ml2_receiver.wire.json_body import Scalar

from ..bags.bag_reader import BagMessage, BagReader
from ..bags.decoding import decoder
from ..geometry.camera import camera_of
from ..geometry.lens import Lens
from ..images.pixels import grey_of
from .numbers import NUMBERS

type Floats = NDArray[np.float64]

_LEAST_MESSAGES = 10
# Decoding every image would take longer than the recording.
_EACH_IMAGE, _MOST_DEPTHS = 10, 3
_SHORT_PERCENT = 10


@dataclass
class StreamEvidence:
    """The data of one stream in one session.

    Attributes:
        values: the values that the headset applied; empty if it refused the stream.
        reasons: why it was adjusted, refused, or had to wait, in the order of their first mention.
        denied: True if the app had no permission for it.
        times_ns: a row for each sample: its stamp, and when it was recorded.
        numbers: a row for each sample that is no image, in the order of its message's fields.
        frames: a row for each image: its stamp and its frame number.
        greys: a row for each of some images: mean and standard deviation of its pixels.
        depths: some depth images by stamp.
        confidences: those that came with them.
        lens: that of a camera.
    """

    values: Mapping[str, Scalar] = field(default_factory=dict)
    reasons: list[str] = field(default_factory=list)
    denied: bool = False
    times_ns: list[tuple[int, int]] = field(default_factory=list)
    numbers: list[tuple[float, ...]] = field(default_factory=list)
    frames: list[tuple[int, int]] = field(default_factory=list)
    greys: list[tuple[float, float]] = field(default_factory=list)
    depths: dict[int, NDArray[np.float32]] = field(default_factory=dict)
    confidences: dict[int, NDArray[np.float32]] = field(default_factory=dict)
    lens: Lens | None = None

    @property
    def is_delivered(self) -> bool:
        return max(len(self.times_ns), len(self.frames)) >= _LEAST_MESSAGES

    @property
    def rate_hz(self) -> float:
        """The rate by the median interval of the device's stamps."""
        return float(1e9 / np.median(self._intervals_ns))

    @property
    def fastest_hz(self) -> float:
        """The rate by short intervals of the stamps, which samples that were lost do not change."""
        return float(1e9 / np.percentile(self._intervals_ns, _SHORT_PERCENT))

    @property
    def highest_hz(self) -> float:
        """The rate by the shortest interval of the stamps."""
        return float(1e9 / np.min(self._intervals_ns))

    @property
    def _intervals_ns(self) -> NDArray[np.int64]:
        stamps_ns = np.unique(np.array(self.frames or self.times_ns, np.int64)[:, 0])
        return np.diff(stamps_ns)

    @property
    def latencies_ms(self) -> Floats:
        """The times from the stamp to the recording."""
        times_ns = np.array(self.times_ns, np.int64)
        return (times_ns[:, 1] - times_ns[:, 0]) / 1e6


type SessionStreams = Mapping[str, StreamEvidence]


@dataclass(frozen=True)
class Evidence:
    """The data of several sessions with one headset.

    Attributes:
        sessions: the streams of each session by id. "tf" has the poses of the head,
            "tf_world_center" those of a camera's body, and "tf_map" the world in the map.
        log: lines of the device's log; None if it was not read.
        is_encrypted: True if the headset was paired; None if that is not known.
        is_behind_adb: True if commands over adb have done what they should.
    """

    sessions: Sequence[SessionStreams]
    log: Sequence[str] | None = None
    is_encrypted: bool | None = None
    is_behind_adb: bool = False

    def all(self, id: str, **values: Scalar) -> Iterator[StreamEvidence]:
        """Yields the sessions of a stream in which the headset applied these values."""
        for session in self.sessions:
            if (it := session.get(id)) and values.items() <= it.values.items():
                yield it

    def find(self, id: str, **values: Scalar) -> StreamEvidence | None:
        """Returns the first session of a stream with these values in which samples came."""
        return next((it for it in self.all(id, **values) if it.is_delivered), None)

    def needed(self, id: str, **values: Scalar) -> StreamEvidence:
        """Returns what find() does, for a judgement that is only asked if there is one."""
        found = self.find(id, **values)
        if found is None:
            raise LookupError(self.why_missing(id, **values))
        return found

    def first_reason(self, pattern: re.Pattern[str]) -> tuple[str, str] | None:
        """Returns the first stream and reason that match as "stream: reason".

        A missing permission is no reason.
        """
        for session in self.sessions:
            for id, it in session.items():
                for reason in it.reasons:
                    if not it.denied and pattern.search(f"{id}: {reason}"):
                        return id, reason
        return None

    def why_missing(self, id: str, **values: Scalar) -> str:
        """Says why find() returns None."""
        for session in self.sessions:
            if (it := session.get(id)) and it.reasons:
                return f"{id}: {it.reasons[-1]}"
        asked = " and ".join(f"{key} {value}" for key, value in values.items())
        return f"no recording has samples of {id}{asked and f' with {asked}'}"


def read_session(folder: Path) -> SessionStreams:
    """Reads one recording.

    Raises:
        RecordingError: the recording cannot be read.
    """
    bag = BagReader(folder)
    session: dict[str, StreamEvidence] = defaultdict(StreamEvidence)
    takers = _takers(bag, session)
    for message in bag.messages():
        if (take := takers.get(message.topic)) is not None:
            try:
                take(message)
            except (ValueError, ProtocolError):
                continue  # `inspect` says what is wrong with a recording
    return dict(session)


def _takers(bag: BagReader, session: dict[str, StreamEvidence]) -> dict[str, Callable[..., None]]:
    table = load_table()
    takers: dict[str, Callable[..., None]] = {
        f"{bag.prefix}/config": partial(_take_config, session)
    }
    for id, stream in table.streams.items():
        for topic in stream.topics:
            name = topic.full_name(bag.prefix)
            is_image = topic.role == "image" and not table.sections[stream.section].shows_eyes
            if name not in bag.types:
                continue
            if topic.role == "metadata":
                takers[name] = partial(_take_metadata, session, id)
            elif topic.role == "camera_info":
                takers[name] = partial(_take_lens, session, id, bag.types[name])
            elif is_image:
                takers[name] = partial(_take_image, session, id, bag.types[name])
            elif topic.role == "confidence":
                takers[name] = partial(_take_confidence, session, id, bag.types[name])
            elif topic.role == "tf":
                takers[name] = partial(_take_transforms, session, _ids_by_frame(table))
            elif bag.types[name] in NUMBERS:
                takers[name] = partial(_take_numbers, session, id, bag.types[name])
    return takers


def _take_config(session: dict[str, StreamEvidence], message: BagMessage) -> None:
    for id, entry in ConfigText.parse(decode_string(message.payload)).streams.items():
        stream = session[id]
        stream.values = entry.values or {}
        stream.denied |= entry.state is not None and entry.state.permission is not None
        for reason in (entry.reason, entry.state and entry.state.reason):
            if reason and reason not in stream.reasons:
                stream.reasons.append(reason)


def _take_metadata(session: dict[str, StreamEvidence], id: str, message: BagMessage) -> None:
    number = json.loads(decode_string(message.payload)).get("frame_number")
    if isinstance(number, int):
        stamp_ns = stamp_reader("std_msgs/msg/String")(message.payload)
        session[id].frames.append((stamp_ns, number))


def _take_lens(session: dict[str, StreamEvidence], id: str, type: str, message: BagMessage) -> None:
    if session[id].lens is None:
        session[id].lens = camera_of(decoder(type)(message.payload)).lens


def _take_image(
    session: dict[str, StreamEvidence], id: str, type: str, message: BagMessage
) -> None:
    stream = session[id]
    stream.times_ns.append((stamp_reader(type)(message.payload), message.time_ns))
    if len(stream.times_ns) % _EACH_IMAGE == 1:
        grey = grey_of(decoder(type)(message.payload))
        seen = grey[np.isfinite(grey)]
        if seen.size:
            stream.greys.append((float(seen.mean()), float(seen.std())))
        if seen.size and id == "depth" and len(stream.depths) < _MOST_DEPTHS:
            stream.depths[stream.times_ns[-1][0]] = grey


def _take_confidence(
    session: dict[str, StreamEvidence], id: str, type: str, message: BagMessage
) -> None:
    """Keeps it if its depth image, which comes before it, is kept."""
    stamp_ns = stamp_reader(type)(message.payload)
    if stamp_ns in session[id].depths:
        session[id].confidences[stamp_ns] = grey_of(decoder(type)(message.payload))


def _ids_by_frame(table: StreamTable) -> Mapping[str, str]:
    """Returns which evidence the poses of a frame are."""
    bodies = {it.body_frame: f"tf_{id}" for id, it in table.streams.items() if it.body_frame}
    return {**bodies, table.head_frame: "tf", table.world_frame: "tf_map"}


def _take_transforms(
    session: dict[str, StreamEvidence], ids: Mapping[str, str], message: BagMessage
) -> None:
    for it in decoder("tf2_msgs/msg/TFMessage")(message.payload).transforms:
        if (id := ids.get(it.child_frame_id.rpartition("/")[2])) is not None:
            t, r = it.transform.translation, it.transform.rotation
            session[id].times_ns.append((header_stamp_ns(it.header), message.time_ns))
            session[id].numbers.append((t.x, t.y, t.z, r.x, r.y, r.z, r.w))


def _take_numbers(
    session: dict[str, StreamEvidence], id: str, type: str, message: BagMessage
) -> None:
    decoded = decoder(type)(message.payload)
    session[id].times_ns.append((header_stamp_ns(decoded.header), message.time_ns))
    session[id].numbers.append(NUMBERS[type](decoded))
