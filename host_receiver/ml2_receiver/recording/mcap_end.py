"""Ends an MCAP file whose writer failed: cuts it to whole chunks, and writes index and footer."""

import errno
import os
import struct
import zlib
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, DataEnd, Footer, Schema, Statistics
from mcap.writer import MCAP0_MAGIC

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_RECORD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")  # times, size, CRC, and the length of the compression's name
_MESSAGE_INDEX = struct.Struct("<HI")
_INDEX_ENTRY_BYTES = 16
_FOOTER_HEAD = struct.Struct("<BQQQ")


@dataclass
class _Chunk:
    """A chunk; `end` is the offset after its message indexes, `counts` its messages by channel."""

    index: ChunkIndex
    end: int
    counts: Counter[int] = field(default_factory=Counter)


@dataclass(frozen=True)
class Kept:
    """The remaining content: messages by channel, times of the first and last one, and bytes."""

    counts: Counter[int]
    first_ns: int
    last_ns: int
    file_bytes: int


def end_file(
    file: int, whole_bytes: int, schemas: Sequence[Schema], channels: Sequence[Channel]
) -> Kept:
    """Keeps the chunks within the first `whole_bytes`, or fewer if the index needs their space.

    The file gets no index if the disk fails for another reason than being full.

    Args:
        file: a descriptor open for reading and writing.

    Raises:
        OSError: the file cannot be read or cut.
    """
    begin, chunks = _chunks(file, whole_bytes)
    while True:
        cut = chunks[-1].end if chunks else begin
        os.ftruncate(file, cut)
        end = _end(cut, chunks, schemas, channels)
        try:
            _write(file, cut, end)
            return _kept(chunks, cut + len(end))
        except OSError as error:
            os.ftruncate(file, cut)
            has_room = cut + len(end) <= whole_bytes
            if error.errno not in _NO_ROOM or has_room or not chunks:
                return _kept(chunks, cut)
            chunks.pop()


def _chunks(file: int, whole_bytes: int) -> tuple[int, list[_Chunk]]:
    """Returns the end of the file's header, and the chunks without reading their messages."""
    chunks: list[_Chunk] = []
    position = begin = len(MCAP0_MAGIC)
    while position < whole_bytes:
        opcode, length = _RECORD.unpack(os.pread(file, _RECORD.size, position))
        content, end = position + _RECORD.size, position + _RECORD.size + length
        if opcode == Opcode.CHUNK:
            chunks.append(_Chunk(_chunk_index(file, position, content, end), end))
        elif opcode == Opcode.MESSAGE_INDEX:
            id, size = _MESSAGE_INDEX.unpack(os.pread(file, _MESSAGE_INDEX.size, content))
            chunk = chunks[-1]
            chunk.index.message_index_offsets[id] = position
            chunk.index.message_index_length += end - position
            chunk.counts[id] += size // _INDEX_ENTRY_BYTES
            chunk.end = end
        elif not chunks:
            begin = end
        position = end
    return begin, chunks


def _chunk_index(file: int, position: int, content: int, end: int) -> ChunkIndex:
    first_ns, last_ns, size, _, name = _CHUNK.unpack(os.pread(file, _CHUNK.size, content))
    records = content + _CHUNK.size + name + 8
    return ChunkIndex(
        chunk_length=end - position,
        chunk_start_offset=position,
        compression=os.pread(file, name, content + _CHUNK.size).decode(),
        compressed_size=end - records,
        message_end_time=last_ns,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=first_ns,
        uncompressed_size=size,
    )


def _end(
    start: int, chunks: Sequence[_Chunk], schemas: Sequence[Schema], channels: Sequence[Channel]
) -> bytes:
    data_end = _records([DataEnd(0)])
    counts = _counts(chunks)
    statistics = Statistics(
        attachment_count=0,
        channel_count=len(channels),
        channel_message_counts=dict(counts),
        chunk_count=len(chunks),
        message_count=counts.total(),
        message_start_time=min((it.index.message_start_time for it in chunks), default=0),
        message_end_time=max((it.index.message_end_time for it in chunks), default=0),
        metadata_count=0,
        schema_count=len(schemas),
    )
    summary = _records([*schemas, *channels, statistics, *(it.index for it in chunks)])
    summary_start = start + len(data_end)
    head = _FOOTER_HEAD.pack(Opcode.FOOTER, 20, summary_start, 0)
    footer = Footer(summary_start, 0, zlib.crc32(head, zlib.crc32(summary)))
    return data_end + summary + _records([footer]) + MCAP0_MAGIC


def _records(
    records: Iterable[Schema | Channel | Statistics | ChunkIndex | DataEnd | Footer],
) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()
    return data


def _write(file: int, position: int, data: bytes) -> None:
    while data:
        written = os.pwrite(file, data, position)
        position, data = position + written, data[written:]


def _counts(chunks: Iterable[_Chunk]) -> Counter[int]:
    counts: Counter[int] = Counter()
    for chunk in chunks:
        counts.update(chunk.counts)
    return counts


def _kept(chunks: Sequence[_Chunk], file_bytes: int) -> Kept:
    return Kept(
        _counts(chunks),
        min((it.index.message_start_time for it in chunks), default=0),
        max((it.index.message_end_time for it in chunks), default=0),
        file_bytes,
    )
