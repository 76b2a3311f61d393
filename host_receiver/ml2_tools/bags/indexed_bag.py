"""Reads parts of a recording by the index of its files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path

from mcap.records import ChunkIndex

from ml2_receiver.errors import RecordingError

from .bag_reader import (
    BagMessage,
    BagReader,
    named_messages,
    pieces,
    whole_summary,
)

_time_ns = attrgetter("time_ns")


@dataclass(frozen=True)
class History:
    """The messages before a time that are wanted of a topic.

    Attributes:
        depth: the number of messages, the newest ones.
        lead_ns: no chunk that ends so long before the time is read for more than the newest
            message; None is no limit.
    """

    depth: int
    lead_ns: int | None


@dataclass(frozen=True)
class _Chunk:
    """A part of a file that is read at once.

    `topics` are those of its messages; None if the file does not say.
    """

    file: Path
    offset: int
    begin_ns: int
    end_ns: int
    topics: frozenset[str] | None


class IndexedBag(BagReader):
    """One recording of `ml2-receiver record`, read from any time on. Not thread-safe.

    It holds at most one chunk of a file in memory. An unfinished recording has no index: then all
    of it is read once, to make one.

    Attributes:
        begin_ns: the time of the first message.
        end_ns: the time of the last message.
        counts: the number of messages by topic; empty if a file does not say.

    Raises:
        RecordingError: the recording cannot be read, or is not one of `ml2-receiver record`.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._names: dict[Path, dict[int, str]] = {}
        self.counts: Counter[str] = Counter()
        chunks: list[_Chunk] = []
        for file in self._files:
            chunks += self._index(file) or self._scan(file)
        if not chunks:
            raise RecordingError(
                f"not supported: {path} has no chunks, by which messages of any time are found",
                hint="`play`, `inspect`, `export` and `evaluate` read it.",
            )
        self._chunks = sorted(chunks, key=lambda it: it.begin_ns)
        self.begin_ns = self._chunks[0].begin_ns
        self.end_ns = max(it.end_ns for it in chunks)

    def after(self, time_ns: int) -> Iterator[BagMessage]:
        """Yields the messages after a time, those of a chunk in the order of their times.

        Raises:
            RecordingError: a file is broken.
        """
        for chunk in self._chunks:
            if chunk.end_ns > time_ns:
                yield from (it for it in self._messages(chunk) if it.time_ns > time_ns)

    def until(self, time_ns: int, wanted: Mapping[str, History]) -> list[BagMessage]:
        """Returns the newest messages of each wanted topic up to a time, in the order of time.

        Raises:
            RecordingError: a file is broken.
        """
        found: dict[str, list[BagMessage]] = {topic: [] for topic in wanted}
        missing = set(wanted)
        for chunk in reversed(self._chunks):
            if chunk.begin_ns > time_ns:
                continue
            offered = missing if chunk.topics is None else missing & chunk.topics
            taken = {it for it in offered if _is_in(chunk, found[it], wanted[it], time_ns)}
            # Earlier chunks have nothing for a topic for which this one has nothing any more.
            missing -= offered - taken
            for message in reversed(self._messages(chunk) if taken else []):
                topic = message.topic
                is_wanted = topic in taken and message.time_ns <= time_ns
                if is_wanted and len(found[topic]) < wanted[topic].depth:
                    found[topic].append(message)
        return sorted((it for them in found.values() for it in them), key=_time_ns)

    def _index(self, file: Path) -> list[_Chunk]:
        """Returns the chunks by the index of a file; none without one."""
        summary = whole_summary(file)
        if summary is None:
            return []
        names = self._names[file] = {it.id: it.topic for it in summary.channels.values()}
        if summary.statistics is not None:
            for id, count in summary.statistics.channel_message_counts.items():
                self.counts[names.get(id, "")] += count
        size = file.stat().st_size
        if any(it.chunk_start_offset >= size for it in summary.chunk_indexes):
            raise RecordingError(f"{file} is broken: its index has chunks after its end")
        # A file without messages may have an empty chunk.
        return [_chunk(file, it, names) for it in summary.chunk_indexes if it.message_end_time]

    def _scan(self, file: Path) -> list[_Chunk]:
        """Returns the chunks of a file without an index, which may be truncated."""
        found = []
        names = self._names[file] = {}
        for piece in pieces(file):
            messages = list(named_messages(file, piece.records, names))
            self.counts.update(it.topic for it in messages)
            if piece.is_chunk and messages:
                times_ns = [it.time_ns for it in messages]
                topics = frozenset(it.topic for it in messages)
                found.append(_Chunk(file, piece.offset, min(times_ns), max(times_ns), topics))
        return found

    def _messages(self, chunk: _Chunk) -> list[BagMessage]:
        piece = next(pieces(chunk.file, chunk.offset), None)
        if piece is None:
            raise RecordingError(f"{chunk.file} has no chunk at byte {chunk.offset}")
        messages = named_messages(chunk.file, piece.records, self._names[chunk.file])
        return sorted(messages, key=_time_ns)


def _is_in(chunk: _Chunk, found: list[BagMessage], wanted: History, time_ns: int) -> bool:
    """Returns True if a chunk may have a wanted message of a topic that it has."""
    if not found:
        return True
    is_recent = wanted.lead_ns is None or chunk.end_ns >= time_ns - wanted.lead_ns
    return is_recent and len(found) < wanted.depth


def _chunk(file: Path, index: ChunkIndex, names: Mapping[int, str]) -> _Chunk:
    ids = index.message_index_offsets
    topics = frozenset(names.get(it, "") for it in ids) if ids else None
    times_ns = index.message_start_time, index.message_end_time
    return _Chunk(file, index.chunk_start_offset, *times_ns, topics)
