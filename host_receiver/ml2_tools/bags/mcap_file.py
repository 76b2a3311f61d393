"""One MCAP file: where its messages are, and the messages; also of a truncated one.

The readers of the mcap library leave out what lies outside of chunks if there are chunks, take
parts of an index for the whole, and unpack without a bound. So only its parsers are used here.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import lz4.frame  # type: ignore[import-untyped]
from mcap.exceptions import McapError, RecordLengthLimitExceeded
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, ChunkIndex, Footer, McapRecord, Message, Schema
from mcap.stream_reader import MAGIC_SIZE, StreamReader, breakup_chunk
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError, frame_content_size

from ml2_receiver.errors import RecordingError

from .bounded_file import MAX_RECORD_BYTES, BoundedFile, open_file
from .foreign_formats import check_format

_RECOVER = "`mcap recover` makes a file of what is whole in it. Read that file alone."
# Messages outside of chunks are read together up to this size.
_RUN_BYTES = 4 * 1024 * 1024
_NEEDED = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE, Opcode.CHUNK)
_RECORD_HEAD = struct.Struct("<BQ")
# Opcode and length of a record, then a channel and the size of the entries, of 16 B each.
_MESSAGE_INDEX_BYTES, _MESSAGE_INDEX_ENTRY_BYTES = 15, 16
# lz4 raises RuntimeError.
_BROKEN = McapError, OverflowError, ValueError, KeyError, RuntimeError, struct.error, ZstdError


@dataclass
class Part:
    """Messages that are read at once: those of a chunk, or some that follow each other.

    Attributes:
        begin, end: where they are in the file, in bytes.
        begin_ns, end_ns: the earliest and the latest time of recording.
        counts: the number of messages by the id of their channel.
    """

    begin: int
    end: int
    begin_ns: int
    end_ns: int
    counts: dict[int, int]
    is_chunk: bool = True

    def add(self, message: Message, end: int) -> None:
        self.end = end
        self.begin_ns = min(self.begin_ns, message.log_time)
        self.end_ns = max(self.end_ns, message.log_time)
        self.counts[message.channel_id] = self.counts.get(message.channel_id, 0) + 1


@dataclass
class Contents:
    """The contents of a file.

    Attributes:
        types: the type of each channel's messages by its id; empty if it has no schema.
        rest_bytes: the size of what follows the last whole record, or the end of the recording.
    """

    channels: dict[int, Channel] = field(default_factory=dict)
    types: dict[int, str] = field(default_factory=dict)
    parts: list[Part] = field(default_factory=list)
    rest_bytes: int = 0


def read_contents(path: Path) -> Contents:
    """Reads the index of a file. Without a whole one, all of the file is read to make it.

    Raises:
        RecordingError: the file is no MCAP, or broken before its end; a truncated one is no error.
    """
    with open_file(path) as file:
        check_format(path, file.read(MAGIC_SIZE))
    return _by_index(path) or _by_reading(path)


def read_messages(path: Path, part: Part) -> list[Message]:
    """Reads a part of a file in the order of the file.

    Raises:
        RecordingError: the file is broken there.
    """
    found = [
        record
        for piece in _pieces(path, part.begin, part.end)
        for record in piece.records
        if isinstance(record, Message)
    ]
    if len(found) != sum(part.counts.values()):
        raise RecordingError(
            f"{path} is broken: byte {part.begin} begins {len(found)} messages, expected"
            f" {sum(part.counts.values())}"
        )
    if any(not part.begin_ns <= it.log_time <= part.end_ns for it in found):
        raise RecordingError(
            f"{path} is broken: its index has other times than the messages at byte {part.begin}",
            hint=_RECOVER,
        )
    return found


def _by_index(path: Path) -> Contents | None:
    """Returns what the index says; None if it is not whole, since all its parts are optional."""
    with open_file(path) as file:
        try:
            summary = SeekingReader(file, record_size_limit=MAX_RECORD_BYTES).get_summary()
        except (*_BROKEN, OSError):
            return None
        is_at_the_end = file.tell() == path.stat().st_size - MAGIC_SIZE
    if summary is None or summary.statistics is None:
        return None
    channels, statistics = summary.channels, summary.statistics
    parts = [_part(it) for it in summary.chunk_indexes]
    counted = {id for part in parts for id in part.counts}
    is_whole = (
        # Messages outside of chunks are in the statistics only.
        sum(sum(it.counts.values()) for it in parts) == statistics.message_count
        and len(channels) >= statistics.channel_count
        and counted <= channels.keys()
        and is_at_the_end
        and all(it.schema_id in {0, *summary.schemas} for it in channels.values())
    )
    if not is_whole:
        return None
    return Contents(channels, _types(summary), [it for it in parts if it.counts])


def _part(index: ChunkIndex) -> Part:
    begin = index.chunk_start_offset
    end = begin + index.chunk_length
    offsets = sorted((offset, id) for id, offset in index.message_index_offsets.items())
    ends = [*(it for it, _ in offsets), end + index.message_index_length]
    counts = {
        id: (end - offset - _MESSAGE_INDEX_BYTES) // _MESSAGE_INDEX_ENTRY_BYTES
        for (offset, id), end in zip(offsets, ends[1:], strict=True)
    }
    counts = {id: count for id, count in counts.items() if count}
    return Part(begin, end, index.message_start_time, index.message_end_time, counts)


def _types(summary: Summary) -> dict[int, str]:
    names = {id: _type(it) for id, it in summary.schemas.items()}
    return {id: names.get(it.schema_id, "") for id, it in summary.channels.items()}


def _type(schema: Schema) -> str:
    """The name of a type; mcap's own writer for ROS 2 leaves out the part in the middle."""
    package, _, name = schema.name.partition("/")
    is_short = package and name and "/" not in name
    return f"{package}/msg/{name}" if is_short else schema.name


def _by_reading(path: Path) -> Contents:
    found, names, end = Contents(), {0: ""}, 0
    for piece in _pieces(path):
        is_last = any(isinstance(it, Footer) for it in piece.records)
        end = piece.end + MAGIC_SIZE * is_last
        part = found.parts[-1] if found.parts else None
        is_new = (
            piece.is_chunk
            or part is None
            or part.is_chunk
            or part.end < piece.begin
            or part.end - part.begin > _RUN_BYTES
        )
        for record in piece.records:
            if isinstance(record, Schema):
                names[record.id] = _type(record)
            elif isinstance(record, Channel):
                found.channels[record.id] = record
                found.types[record.id] = names.get(record.schema_id, "")
            elif isinstance(record, Message):
                if is_new or part is None:
                    times_ns = record.log_time, record.log_time
                    part = Part(piece.begin, piece.end, *times_ns, {}, piece.is_chunk)
                    found.parts.append(part)
                    is_new = False
                part.add(record, piece.end)
    found.rest_bytes = max(0, path.stat().st_size - end)
    return found


class _Piece(NamedTuple):
    """Records that are read at once: those in a chunk, or one outside of chunks."""

    begin: int
    end: int
    records: list[McapRecord]
    is_chunk: bool


def _pieces(path: Path, begin: int = 0, end: int | None = None) -> Iterator[_Piece]:
    """Yields the pieces of a file, from one's beginning on until one ends at `end`.

    Raises:
        RecordingError: the file is broken before its end; a truncated file is no error.
    """
    with open_file(path) as file:
        file.seek(begin)
        reader = _stream_reader(file, is_whole=not begin)
        begin = max(begin, MAGIC_SIZE)
        while end is None or begin < end:
            try:
                record = next(reader, None)
                is_chunk = isinstance(record, Chunk)
                records = _split_chunk(record) if isinstance(record, Chunk) else [record]
            except RecordLengthLimitExceeded as error:
                begin = _after_large_record(path, file, begin, error)
                file.seek(begin)
                reader = _stream_reader(file, is_whole=False)
                continue
            except _BROKEN as error:
                if _is_truncated(path, file):
                    return
                reason = str(error) or "it ends within a record"
                raise RecordingError(f"{path} is broken: {reason}", hint=_RECOVER) from error
            if record is None:
                return
            yield _Piece(begin, file.tell(), [it for it in records if it is not None], is_chunk)
            begin = file.tell()


def _stream_reader(file: BoundedFile, *, is_whole: bool) -> Iterator[McapRecord]:
    return StreamReader(
        file,
        skip_magic=not is_whole,
        emit_chunks=True,
        validate_crcs=is_whole,
        record_size_limit=MAX_RECORD_BYTES,
    ).records


def _after_large_record(path: Path, file: BoundedFile, begin: int, error: McapError) -> int:
    """Returns where a record ends that is too large and need not be read."""
    head_end = file.tell()
    file.seek(head_end - _RECORD_HEAD.size)
    opcode, length = _RECORD_HEAD.unpack(file.read(_RECORD_HEAD.size))
    size = path.stat().st_size
    if head_end + length > size:
        raise RecordingError(
            f"{path} is broken: byte {begin} begins a record of {length} B, the file has {size} B"
        ) from error
    if opcode in _NEEDED:
        raise RecordingError(
            f"not supported: {path} has a {Opcode(opcode).name.lower()} of {length} B, at most"
            f" {MAX_RECORD_BYTES} B are"
        ) from error
    return head_end + int(length)


def _is_truncated(path: Path, file: BoundedFile) -> bool:
    """Returns True if the file was read to its end, but does not end as a finished one."""
    size = path.stat().st_size
    if 0 < size < MAGIC_SIZE:
        return True
    if file.tell() < size or size == 0:
        return False
    file.seek(size - MAGIC_SIZE)
    return file.read(MAGIC_SIZE) != MCAP0_MAGIC


def _split_chunk(chunk: Chunk) -> list[McapRecord]:
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":
        size = max(size, frame_content_size(chunk.data))
    if size > MAX_RECORD_BYTES:
        raise RecordingError(
            f"not supported: a chunk of {size} B, at most {MAX_RECORD_BYTES} B are"
        )
    if chunk.compression == "lz4":
        # Bounded, where mcap would unpack whatever the data say.
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
        if len(data) != size:
            raise ValueError(f"a chunk is not of {size} B, as it says")
        chunk = replace(chunk, compression="", data=data)
    elif chunk.compression not in ("", "zstd"):
        raise RecordingError(
            f"not supported: chunks compressed with {chunk.compression!r}; zstd and lz4 are"
        )
    return breakup_chunk(chunk, validate_crc=True)
