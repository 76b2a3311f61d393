"""Chooses the topics of a recording that are read, and counts the messages that are not."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from ml2_receiver.errors import RecordingError

from .mcap_file import Contents

_CDR = "cdr"
_MOST_SHOWN = 200
type Kind = tuple[str, str, str]


class BagTopics:
    """The topics of the files of a recording.

    Attributes:
        types: the type of each topic, by its absolute name.
        names: for each file, the topics by the id of their channel.

    Raises:
        RecordingError: all messages are of encodings that are not read.
    """

    def __init__(self, path: Path, files: Sequence[Contents]) -> None:
        self._counts = Counter[Kind]()
        self._without_channel = 0
        for it in files:
            for id in it.channels:
                self._counts[_kind(it, id)] += 0
            for part in it.parts:
                for id, count in part.counts.items():
                    if id in it.channels:
                        self._counts[_kind(it, id)] += count
                    else:
                        self._without_channel += count
        if not self._counts:
            lost = self._without_channel
            only = f", only {lost} messages whose topic no record tells" if lost else ""
            raise RecordingError(f"{path} has no topics{only}", hint="Nothing was recorded.")
        # If a topic has several types, the type with the most messages is read.
        readable = [it for it, _ in self._counts.most_common() if it[2] == _CDR]
        self.types = {topic: type for topic, type, _ in reversed(readable)}
        if self._counts and not readable:
            found = ", ".join(f"{topic} ({type}) as {it!r}" for topic, type, it in self._counts)
            raise RecordingError(
                f"not supported: {path} has only {found[:_MOST_SHOWN]}, expected {_CDR!r}",
                hint="Convert it to a recording of ROS 2.",
            )
        self.names: list[dict[int, str]] = []
        self._files = files
        self.restrict(lambda _: True)

    @property
    def are_all_read(self) -> bool:
        return not self._without_channel and all(map(self._is_read, self._counts))

    def restrict(self, has: Callable[[str], bool]) -> None:
        """Leaves out the topics for which `has` returns False."""
        self.types = {topic: type for topic, type in self.types.items() if has(topic)}
        self.names = [
            {id: kind[0] for id in it.channels if self._is_read(kind := _kind(it, id))}
            for it in self._files
        ]

    def left_out(self) -> Iterable[str]:
        """Yields what is not read, in words."""
        of_others = 0
        for kind, count in sorted(self._counts.items()):
            topic, type, encoding = kind
            if not count or self._is_read(kind):
                continue
            if encoding != _CDR:
                yield f"{count} messages of {topic}, which are {encoding!r}, expected {_CDR!r}"
            elif topic in self.types:
                yield f"{count} messages of {topic} of type {type}; most are {self.types[topic]}"
            else:
                of_others += count
        if of_others:
            yield f"{of_others} messages of other headsets"
        if self._without_channel:
            yield f"{self._without_channel} messages whose topic no record tells"

    def _is_read(self, kind: Kind) -> bool:
        topic, type, encoding = kind
        return encoding == _CDR and self.types.get(topic) == type


def _kind(contents: Contents, id: int) -> Kind:
    channel = contents.channels[id]
    return channel.topic, contents.types[id], channel.message_encoding
