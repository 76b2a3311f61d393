"""Reads parts of a recording by the index of its files."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from .bag_reader import BagMessage, BagPart, BagReader
from .copies import LAG_NS, Copies

# Its time, its part, its place there, its file, and the message.
type _Found = tuple[int, int, int, int, BagMessage]


@dataclass(frozen=True)
class History:
    """The messages before a time that are wanted of a topic.

    Attributes:
        depth: the number of messages, the newest ones.
        lead_ns: no part that ends so long before the time is read for more than the newest
            message; None is no limit.
    """

    depth: int
    lead_ns: int | None


class IndexedBag(BagReader):
    """A recording that is read from any time on. Not thread-safe.

    An unfinished recording has no index: then all of it is read once, to make one.

    Attributes:
        counts: the number of messages by topic.

    Raises:
        RecordingError: as for BagReader.
    """

    def __init__(self, path: Path, headset: str | None = None) -> None:
        super().__init__(path, headset)
        self.counts = Counter[str]()
        if self._may_have_copies or (self._headset and self._headset.others):
            self.counts.update(it.topic for it in self.messages())
            return
        for it in self._parts:
            names = self._topics.names[it.file]
            for id, count in it.part.counts.items():
                if id in names:
                    self.counts[names[id]] += count

    def after(self, time_ns: int) -> Iterator[BagMessage]:
        """Yields the messages after a time in the order of their times.

        Raises:
            RecordingError: a file is broken.
        """
        from_ns = time_ns - LAG_NS if self._may_have_copies else time_ns
        parts = [it for it in self._parts if it.part.end_ns > from_ns]
        return (it for it in self._in_order(parts) if it.time_ns > time_ns)

    def until(self, time_ns: int, wanted: Mapping[str, History]) -> list[BagMessage]:
        """Returns the newest messages of each wanted topic up to a time, in the order of time.

        Raises:
            RecordingError: a file is broken.
        """
        found: dict[str, list[_Found]] = {topic: [] for topic in wanted}
        missing = set(wanted)
        earlier = (it for it in self._parts if it.begin_ns <= time_ns)
        for part in sorted(earlier, key=lambda it: (-it.part.end_ns, -it.number)):
            missing = {it for it in missing if _may_have(part, found[it], wanted[it], time_ns)}
            if not missing:
                break
            for place, message in enumerate(self._read(part) if part.topics & missing else ()):
                topic = message.topic
                if topic in missing and message.time_ns <= time_ns:
                    place_of = message.time_ns, part.number, place
                    found[topic].append((*place_of, part.file, message))
            for topic in missing:
                copies = Copies()
                once = [it for it in sorted(found[topic]) if not copies.is_copy(*it[-2:])]
                found[topic] = once[-wanted[topic].depth :]
        return [message for *_, message in sorted(it for them in found.values() for it in them)]


def _may_have(part: BagPart, found: list[_Found], wanted: History, time_ns: int) -> bool:
    """Returns True if a part, or one that ends earlier, may have a wanted message of a topic."""
    if not found:
        return True
    end_ns = part.part.end_ns
    if len(found) == wanted.depth:
        return end_ns > found[0][0]
    return wanted.lead_ns is None or end_ns >= time_ns - wanted.lead_ns
