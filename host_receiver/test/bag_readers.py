"""Recordings as three readers see them that know nothing of each other or of ours."""

import hashlib
import json
import os
import struct
import subprocess
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import DecodedMessageTuple, make_reader
from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader

from ros_messages import TYPES
from waiting import LIMIT_S

_HERE = Path(__file__).parent
_NODE_MODULES = _HERE.parents[1] / "build/javascript/node_modules"


@dataclass(frozen=True)
class Seen:
    """A message; `stamp` is the first one in it, in s and ns, decoded by the reader."""

    topic: str
    type: str
    stamp: tuple[int, int] | None
    sha256: str


def digest(payload: bytes) -> str:
    return hashlib.sha256(payload).hexdigest()


def with_rosbags(folder: Path) -> list[Seen]:
    """Reads with rosbags, which opens the folder with its metadata.yaml."""
    with Reader(folder) as reader:
        return [
            Seen(
                connection.topic,
                connection.msgtype,
                _stamp(TYPES.deserialize_cdr(data, connection.msgtype)),
                digest(data),
            )
            for connection, _, data in reader.messages()
        ]


def with_mcap(folder: Path) -> list[Seen]:
    """Reads with mcap and mcap-ros2-support, through the index."""
    return [_show(*found) for found in _indexed(folder)]


def decoded_with_rosbags(folder: Path) -> list[tuple[str, Any]]:
    """Returns topics and messages."""
    with Reader(folder) as reader:
        return [
            (connection.topic, TYPES.deserialize_cdr(data, connection.msgtype))
            for connection, _, data in reader.messages()
        ]


def decoded_with_mcap(folder: Path) -> list[tuple[str, Any]]:
    """Returns topics and messages."""
    return [(it.channel.topic, it.decoded_message) for it in _indexed(folder)]


def _indexed(folder: Path) -> list[DecodedMessageTuple]:
    with mcap_file(folder).open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return list(reader.iter_decoded_messages())


def with_mcap_sequentially(folder: Path) -> list[Seen]:
    """Reads whole records until the first incomplete one."""
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    found = []
    with mcap_file(folder).open("rb") as file, suppress(McapError, struct.error, ValueError):
        for record in StreamReader(file, validate_crcs=True).records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                schema = schemas[channel.schema_id]
                decode = DecoderFactory().decoder_for(channel.message_encoding, schema)
                assert decode is not None
                found.append(_show(schema, channel, record, decode(record.data)))
    return found


def with_javascript(folder: Path) -> list[Seen]:
    """Reads with @mcap/core and @foxglove/rosmsg2-serialization, through the index."""
    return _javascript(folder, "indexed")


def with_javascript_sequentially(folder: Path) -> list[Seen]:
    """Reads whole records until the first incomplete one."""
    return _javascript(folder, "sequential")


READERS: list[Callable[[Path], list[Seen]]] = [with_rosbags, with_mcap, with_javascript]


def mcap_file(folder: Path) -> Path:
    return folder / f"{folder.name}_0.mcap"


def _show(schema: Schema | None, channel: Channel, message: Message, decoded: object) -> Seen:
    type = schema.name if schema else ""
    return Seen(channel.topic, type, _stamp(decoded), digest(message.data))


def _stamp(message: object) -> tuple[int, int] | None:
    transforms = getattr(message, "transforms", None)
    header = getattr(transforms[0] if transforms else message, "header", None)
    return None if header is None else (header.stamp.sec, header.stamp.nanosec)


def _javascript(folder: Path, mode: str) -> list[Seen]:
    assert _NODE_MODULES.is_dir(), "run `make check` once: it installs the JavaScript reader"
    result = subprocess.run(
        ["node", str(_HERE / "javascript/read_bag.cjs"), mode, str(mcap_file(folder))],
        env={**os.environ, "NODE_PATH": str(_NODE_MODULES)},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    if result.returncode:
        raise ValueError(result.stderr)
    seen = []
    for line in result.stdout.splitlines():
        row = json.loads(line)
        stamp = tuple(row["stamp"]) if "stamp" in row else None
        seen.append(Seen(row["topic"], row["type"], stamp, row["sha256"]))
    return seen
