"""Reads recordings, also truncated ones of a receiver that was killed."""

import io
import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import MAGIC_SIZE, StreamReader, breakup_chunk
from mcap.summary import Summary

from ml2_receiver.errors import ProtocolError, RecordingError
from ml2_receiver.topics.config_topic import ConfigText
from ml2_receiver.topics.string_message import decode_string

from .bag_files import bag_files

# Of a record that is read, and of a chunk that is unpacked. `ml2-receiver record` ends a chunk with
# the message that makes it larger than 4 MiB; other programs make some of 100 MB.
MAX_RECORD_BYTES = 256 * 1024 * 1024
_CONFIG_SUFFIX, _STRING = "/config", "std_msgs/msg/String"
BROKEN = (McapError, OverflowError, ValueError, KeyError, struct.error, zstandard.ZstdError)


@dataclass(frozen=True)
class BagMessage:
    """A recorded message; `time_ns` is its time of recording, `payload` the CDR bytes as sent."""

    topic: str
    time_ns: int
    payload: bytes


class Bag:
    """One recording, by this receiver or any other program that writes rosbag2 as MCAP.

    Args:
        path: a folder with one or more .mcap files, or one such file.

    Attributes:
        types: the type of each topic, by its absolute name.

    Raises:
        RecordingError: the recording cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._files = bag_files(path, _first_ns)
        self.types = self._read_types()

    @property
    def size_bytes(self) -> int:
        return sum(file.stat().st_size for file in self._files)

    def messages(self) -> Iterator[BagMessage]:
        """Yields all messages in the order of the files, which is that of arrival; checks CRCs.

        Raises:
            RecordingError: a file is broken before its end; a truncated file is no error.
        """
        for file in self._files:
            yield from named_messages(file, _records(file), {})

    def _read_types(self) -> Mapping[str, str]:
        types = {}
        for file in self._files:
            schemas: dict[int, str] = {}
            for record in _indexed(file) or _records(file):
                if isinstance(record, Schema):
                    schemas[record.id] = record.name
                elif isinstance(record, Channel):
                    types[record.topic] = schemas.get(record.schema_id, "")
        return types


class BagReader(Bag):
    """One recording of `ml2-receiver record`.

    Attributes:
        config: the headset's answer to the first configuration.
        prefix: the prefix of the headset's topics.

    Raises:
        RecordingError: the recording cannot be read, or is not one of `ml2-receiver record`.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._path = path
        names = {
            name
            for name, type in self.types.items()
            if name.endswith(_CONFIG_SUFFIX) and type == _STRING
        }
        if not names:
            raise RecordingError(
                f"{path} is not a recording of ml2-receiver: it has no topic .../config"
            )
        topic, self.config = self._read_config(names)
        self.prefix = topic.removesuffix(_CONFIG_SUFFIX)

    def _read_config(self, names: set[str]) -> tuple[str, ConfigText]:
        """The headset's configuration, by its content: other nodes may name a topic so, too."""
        found: dict[str, ConfigText] = {}
        wrong: dict[str, Exception] = {}
        for message in self.messages():
            topic = message.topic
            if topic not in names or topic in found or topic in wrong:
                continue
            try:
                found[topic] = ConfigText.parse(decode_string(message.payload))
            except (ValueError, ProtocolError) as error:
                wrong[topic] = error
            if len(found) + len(wrong) == len(names):
                break
        # An app's own topics are below its headset's, whatever they say.
        prefixes = [it.removesuffix(_CONFIG_SUFFIX) for it in found]
        found = {
            topic: config
            for topic, config in found.items()
            if not any(topic.startswith(f"{prefix}/custom/") for prefix in prefixes)
        }
        if len(found) > 1:
            several = ", ".join(sorted(it.removesuffix(_CONFIG_SUFFIX) for it in found))
            raise RecordingError(
                f"{self._path} has several headsets: {several}",
                hint="Copy the topics of one of them into a recording of its own.",
            )
        for topic, config in found.items():
            return topic, config
        for topic, mistake in wrong.items():
            raise RecordingError(f"{self._path}: {topic}: {mistake}") from mistake
        topic = sorted(names)[0]
        raise RecordingError(f"{self._path} has no message on {topic}: no headset was connected")


class Piece(NamedTuple):
    """Records that are read at once: those in a chunk, or one outside of chunks."""

    offset: int
    records: list[McapRecord]
    is_chunk: bool


def named_messages(
    file: Path, records: Iterable[McapRecord], names: dict[int, str]
) -> Iterator[BagMessage]:
    """Yields the messages among the records of a file.

    Args:
        names: the topics by the ids of channels so far; those of the records are added.

    Raises:
        RecordingError: a message is of an unknown channel.
    """
    for record in records:
        if isinstance(record, Channel):
            names[record.id] = record.topic
        elif isinstance(record, Message):
            if record.channel_id not in names:
                raise RecordingError(f"{file}: message of an unknown channel")
            yield BagMessage(names[record.channel_id], record.log_time, record.data)


def pieces(path: Path, offset: int = 0) -> Iterator[Piece]:
    """Yields the pieces of a file in their order, from a piece's offset on; 0 is the beginning.

    Raises:
        RecordingError: the file is broken before its end; a truncated file is no error.
    """
    with open_file(path) as file:
        file.seek(offset)
        reader = StreamReader(
            file,
            skip_magic=offset > 0,
            emit_chunks=True,
            validate_crcs=not offset,
            record_size_limit=MAX_RECORD_BYTES,
        )
        offset = max(offset, MAGIC_SIZE)
        try:
            for record in reader.records:
                if isinstance(record, Chunk):
                    yield Piece(offset, _split_chunk(record), is_chunk=True)
                else:
                    yield Piece(offset, [record], is_chunk=False)
                offset = file.tell()
        except BROKEN as error:
            if file.tell() < path.stat().st_size or file.tell() == 0:
                raise RecordingError(f"{path} is broken: {error}") from error


def _split_chunk(chunk: Chunk) -> list[McapRecord]:
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":
        size = max(size, zstandard.frame_content_size(chunk.data))
    if size > MAX_RECORD_BYTES:
        raise RecordingError(f"not supported: a chunk of {size} B, at most {MAX_RECORD_BYTES} are")
    if chunk.compression == "lz4":
        # Bounded, where mcap would unpack whatever the data say.
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
        chunk = replace(chunk, compression="", data=data)
    elif chunk.compression not in ("", "zstd"):
        raise RecordingError(
            f"not supported: chunks compressed with {chunk.compression!r}; zstd and lz4 are"
        )
    return breakup_chunk(chunk, validate_crc=True)


def _indexed(path: Path) -> list[McapRecord]:
    """Returns the schemas and channels in the file's index; an empty list without a full one."""
    summary = whole_summary(path)
    return [] if summary is None else [*summary.schemas.values(), *summary.channels.values()]


def whole_summary(path: Path) -> Summary | None:
    """The index of a file, if it has all parts that are read; all of them are optional."""
    with open_file(path) as file:
        try:
            summary = SeekingReader(file, record_size_limit=MAX_RECORD_BYTES).get_summary()
        except (*BROKEN, OSError):
            return None
    if summary is None or summary.statistics is None:
        return None
    statistics = summary.statistics
    is_whole = (
        len(summary.channels) == statistics.channel_count
        and len(summary.chunk_indexes) == statistics.chunk_count
        and all(it.schema_id in {0, *summary.schemas} for it in summary.channels.values())
        and sum(statistics.channel_message_counts.values()) == statistics.message_count
    )
    return summary if is_whole else None


def _first_ns(path: Path) -> int | None:
    """The time of a file's first message; None without one."""
    summary = whole_summary(path)
    if summary is not None and summary.statistics is not None:
        statistics = summary.statistics
        return statistics.message_start_time if statistics.message_count else None
    times = (it.log_time for it in _records(path) if isinstance(it, Message))
    return next(times, None)


def _records(path: Path) -> Iterator[McapRecord]:
    return (record for piece in pieces(path) for record in piece.records)


class _BoundedFile(io.BufferedReader):
    """A file that refuses to read more bytes at once than the largest record has."""

    def read(self, size: int | None = -1, /) -> bytes:
        if size is None or not 0 <= size <= MAX_RECORD_BYTES:
            raise ValueError(f"a record has {size} B, expected at most {MAX_RECORD_BYTES}")
        return super().read(size)


def open_file(path: Path) -> _BoundedFile:
    try:
        return _BoundedFile(io.FileIO(path))
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error.strerror}") from error
