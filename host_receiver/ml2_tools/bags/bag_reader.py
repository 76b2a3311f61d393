"""Reads recordings, also truncated ones of a receiver that was killed."""

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import NamedTuple

from ml2_receiver.errors import RecordingError

from .bag_files import bag_files, messages_compressed
from .bag_topics import BagTopics
from .copies import Copies
from .foreign_formats import ZSTD_MAGIC, plain_cdr
from .headsets import Headset, choose, config_topics
from .mcap_file import Part, read_contents, read_messages

_NEVER = (1 << 64, 0)  # times of MCAP have 64 bits
_MOST_NS = (1 << 63) - 1
# A pause between files that nobody says belong together.
_APART_NS = 60_000_000_000
# Maximum bytes waiting in memory across all parts, since parts overlap.
_MOST_WAITING_BYTES = 2 << 30


@dataclass(frozen=True)
class BagMessage:
    """A recorded message; `time_ns` is its time of recording, `payload` the CDR bytes as sent."""

    topic: str
    time_ns: int
    payload: bytes


class BagPart(NamedTuple):
    """Messages of a recording that are read at once; parts compare by when they begin.

    Attributes:
        number: counts the parts in the order of the files.
        file: counts the files.
        topics: those of the messages, without those that are left out.
    """

    begin_ns: int
    number: int
    file: int
    part: Part
    topics: frozenset[str]


class Bag:
    """One recording, by this receiver or any other program that writes rosbag2 as MCAP.

    While it is read, the parts of its files that overlap in time are in memory: as recorders write
    them, one chunk of each file. Not thread-safe.

    Args:
        path: a folder with one or more .mcap files, or one such file.

    Attributes:
        types: the type of each topic, by its absolute name.

    Raises:
        RecordingError: the recording cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._files, self._notes = bag_files(path)
        contents = [read_contents(file) for file in self._files]
        self._topics = BagTopics(path, contents)
        self._all_parts = [(file, part) for file, it in enumerate(contents) for part in it.parts]
        for number, part in self._all_parts:
            if part.end_ns > _MOST_NS:
                raise RecordingError(
                    f"not supported: {self._files[number]} has a message at {part.end_ns} ns, the"
                    f" last time of ROS is {_MOST_NS} ns"
                )
        self._copies = Copies()
        self._place()
        self._notes += [
            f"{it.rest_bytes} B at the end of {file.name}, which are no whole message"
            for file, it in zip(self._files, contents, strict=True)
            if it.rest_bytes
        ]

    @property
    def types(self) -> Mapping[str, str]:
        return self._topics.types

    @property
    def size_bytes(self) -> int:
        return sum(file.stat().st_size for file in self._files)

    @property
    def begin_ns(self) -> int:
        """The time of the first message; 0 without one."""
        if self._topics.are_all_read:
            return self._parts[0].begin_ns if self._parts else 0
        return next((it.time_ns for it in self._in_order(self._parts)), 0)

    @property
    def end_ns(self) -> int:
        """The time of the last message; 0 without one."""
        end_ns = 0
        for it in sorted(self._parts, key=lambda it: -it.part.end_ns):
            if it.part.end_ns <= end_ns:
                break
            if self._topics.are_all_read:
                return it.part.end_ns
            end_ns = max([end_ns, *(message.time_ns for message in self._read(it))])
        return end_ns

    @property
    def left_out(self) -> list[str]:
        """Sentences on what messages() left out, after it has read the recording once."""
        copies = self._copies.count
        words = [f"{copies} messages that another file has, too"] if copies else []
        return [*self._notes, *self._topics.left_out(), *words]

    @property
    def apart(self) -> list[str]:
        """Sentences on pauses after which the files may belong to another recording.

        There are none if metadata.yaml says that the files belong together.
        """
        if len(self._files) < 2 or (self._path / "metadata.yaml").exists():
            return []
        found, last = [], None
        for it in self._parts:
            pause_ns = 0 if last is None else it.begin_ns - last.part.end_ns
            if last is not None and pause_ns > _APART_NS and it.file != last.file:
                names = self._files[it.file].name, self._files[last.file].name
                pause = timedelta(seconds=pause_ns // 1_000_000_000)
                found.append(
                    f"{names[0]} begins {pause} h after {names[1]} ends; name one of them if they"
                    " are two recordings"
                )
            if last is None or it.part.end_ns >= last.part.end_ns:
                last = it
        return found

    def messages(self) -> Iterator[BagMessage]:
        """Yields all messages in the order of their times; checks CRCs.

        A message that several files have comes once.

        Raises:
            RecordingError: a file is broken before its end; a truncated file is no error.
        """
        self._copies = Copies()
        yield from self._in_order(self._parts, self._copies)

    def _place(self) -> None:
        """Finds the parts that have messages of the topics that are read."""
        placed = (
            BagPart(part.begin_ns, number, file, part, self._topics_of(file, part))
            for number, (file, part) in enumerate(self._all_parts)
        )
        self._parts = sorted((it for it in placed if it.topics), key=lambda it: it[:2])
        self._may_have_copies = _may_have_copies(self._parts)

    def _topics_of(self, file: int, part: Part) -> frozenset[str]:
        names = self._topics.names[file]
        return frozenset(names[id] for id in part.counts if id in names)

    def _in_order(
        self, parts: Sequence[BagPart], copies: Copies | None = None
    ) -> Iterator[BagMessage]:
        """Yields the messages of parts, which are in the order of their beginnings."""
        copies = copies or Copies()
        waiting: list[tuple[int, int, int, int, BagMessage]] = []
        waiting_bytes = 0
        begins = [*(it[:2] for it in parts[1:]), _NEVER]
        for it, following in zip(parts, begins, strict=False):
            read = self._read(it)
            waiting += (
                (message.time_ns, it.number, place, it.file, message)
                for place, message in enumerate(read)
            )
            waiting.sort()
            ready = waiting[: bisect_left(waiting, following, key=_place_of)]
            del waiting[: len(ready)]
            waiting_bytes += sum(len(it.payload) for it in read)
            waiting_bytes -= sum(len(it[-1].payload) for it in ready)
            if waiting_bytes > _MOST_WAITING_BYTES:
                raise RecordingError(
                    f"not supported: {self._path} has chunks of {waiting_bytes} B that overlap in"
                    f" time, at most {_MOST_WAITING_BYTES} B are",
                    hint="`mcap sort` writes its messages in the order of time.",
                )
            for *_, file, message in ready:
                if not (self._may_have_copies and copies.is_copy(file, message)):
                    yield message

    def _read(self, it: BagPart) -> list[BagMessage]:
        """The messages of a part in the order of the file."""
        file, names = self._files[it.file], self._topics.names[it.file]
        found = []
        for record in read_messages(file, it.part):
            if record.channel_id in names:
                if record.data.startswith(ZSTD_MAGIC):
                    raise messages_compressed(file)
                name = names[record.channel_id]
                payload = plain_cdr(file, name, record.data)
                found.append(BagMessage(name, record.log_time, payload))
        return found


class BagReader(Bag):
    """The topics of one headset, and those of no headset, in a recording of `ml2-receiver record`.

    Args:
        headset: the prefix of its topics, the name of its receiver, or that of the device; None if
            the recording has only one.

    Attributes:
        config: the headset's answer to the first configuration.
        prefix: the prefix of the headset's topics.

    Raises:
        RecordingError: the recording cannot be read, is not one of `ml2-receiver record`, or has
            several headsets or none of that name.
    """

    def __init__(self, path: Path, headset: str | None = None) -> None:
        self._headset: Headset | None = None
        super().__init__(path)
        firsts = self._first_payloads(config_topics(self.types))
        self._headset = choose(path, firsts, headset)
        self.config, self.prefix = self._headset.config, self._headset.prefix
        if self._headset.others:
            self._topics.restrict(self._headset.has)
            self._place()

    def _first_payloads(self, topics: set[str]) -> dict[str, bytes | None]:
        found: dict[str, bytes | None] = dict.fromkeys(topics)
        missing = set(topics)
        for part in self._parts:
            for message in self._read(part) if part.topics & missing else ():
                if message.topic in missing:
                    found[message.topic] = message.payload
                    missing.remove(message.topic)
        return found

    def _read(self, it: BagPart) -> list[BagMessage]:
        found, headset = super()._read(it), self._headset
        if headset is None or not headset.others:
            return found
        types = self.types
        return [it for it in found if headset.has_message(types[it.topic], it.payload)]


def _place_of(waiting: tuple[int, int, int, int, BagMessage]) -> tuple[int, int]:
    return waiting[:2]


def _may_have_copies(parts: Sequence[BagPart]) -> bool:
    """Returns True if two files overlap in time and have a topic in common."""
    ends_ns: dict[str, dict[int, int]] = {}
    for it in parts:
        for topic in it.topics:
            by_file = ends_ns.get(topic, {})
            others = {file: end for file, end in by_file.items() if end >= it.begin_ns}
            if others.keys() - {it.file}:
                return True
            ends_ns[topic] = {it.file: max(others.get(it.file, 0), it.part.end_ns)}
    return False
