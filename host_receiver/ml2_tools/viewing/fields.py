"""The numeric fields of message types, any of which a browser may plot."""

import functools
import re
from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any, NamedTuple

from ml2_receiver.recording.message_definitions import DEFINITIONS

from ..monitoring.topic_table import Rows

type Path = tuple[str | int, ...]

# Decoding images for a number in their header costs too much.
_IMAGES = frozenset(
    (
        "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
        "foxglove_msgs/msg/CompressedVideo",
        "sensor_msgs/msg/CompressedImage",
        "sensor_msgs/msg/Image",
    )
)
_NUMBER = re.compile(r"bool|byte|char|u?int(8|16|32|64)|float(32|64)")
_FIELD = re.compile(r"([\w/]+)(\[(?:<=)?(\d*)\])?\s+(\w+)\s*(?:#.*)?$", re.ASCII)
_TIME = "builtin_interfaces/Time"
# Maximum elements shown of a sequence without a length. A hand has 26 joints.
_MOST_ELEMENTS = 26
_MOST_FIELDS, _MOST_TOPICS = 250, 500
_TOPIC = re.compile(r"(/[a-z]\w*)+", re.ASCII | re.IGNORECASE)


@functools.cache
def fields_of(type: str) -> Mapping[str, Path]:
    """Returns the path of each numeric field of a type by its name, such as "poses[0].position.x".

    A type that is not in the stream table, and one of images, has none.
    """
    if type in _IMAGES or type not in DEFINITIONS:
        return {}
    own, *others = re.split(r"^=+\nMSG: ", DEFINITIONS[type], flags=re.MULTILINE)
    texts = {it.partition("\n")[0].strip(): it.partition("\n")[2] for it in others}
    return {_name(it): it for it in islice(_paths(own, texts), _MOST_FIELDS)}


class TopicField(NamedTuple):
    """One numeric field of one topic."""

    topic_and_type: tuple[str, str]
    path: Path

    def read(self, message: Any) -> tuple[float, ...]:
        """Returns the number of a decoded message; none if its sequence is not so long."""
        for step in self.path:
            if isinstance(step, str):
                message = getattr(message, step)
            elif step < len(message):
                message = message[step]
            else:
                return ()
        return (float(message),)


def plottable_topics(rows: Rows) -> Mapping[str, str]:
    """Returns the type of each topic of /diagnostics that has numeric fields, at most 500."""
    return {
        name: type
        for name, it in islice(rows.items(), _MOST_TOPICS)
        if _TOPIC.fullmatch(name) and fields_of(type := it.get("type", ""))
    }


def topic_fields(types: Mapping[str, str]) -> Mapping[str, TopicField]:
    """Returns the fields of topics of these types, by topic and field with a space between."""
    return {
        f"{topic} {field}": TopicField((topic, type), path)
        for topic, type in types.items()
        for field, path in fields_of(type).items()
    }


def _paths(text: str, texts: Mapping[str, str]) -> Iterator[Path]:
    for line in text.splitlines():
        if (found := _FIELD.match(line)) is None:
            continue
        type, array, size, name = found.groups()
        inner = list(_paths(texts[type], texts)) if type in texts and type != _TIME else []
        ends: list[Path] = [()] if _NUMBER.fullmatch(type) else inner
        count = int(size) if size else _MOST_ELEMENTS
        steps: list[Path] = [(name,)] if array is None else [(name, it) for it in range(count)]
        yield from (step + end for step in steps for end in ends)


def _name(path: Path) -> str:
    return "".join(f"[{it}]" if isinstance(it, int) else f".{it}" for it in path).removeprefix(".")
