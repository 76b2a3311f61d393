"""What a recording has, and what it answers to a configuration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ml2_receiver.errors import RecordingError
from ml2_receiver.session.streams import Request
from ml2_receiver.table.stream_table import StreamTable, Topic
from ml2_receiver.topics.config_topic import StreamEntry
from ml2_receiver.wire.messages import StreamAnswer

from ..bags.bag_reader import BagReader

_MISSING = "the recording does not have it"
LEFT_OUT = "--topics leaves it out"
_DIFFERENT = "recorded so"


@dataclass(frozen=True)
class Repertoire:
    """What can be played of one recording.

    Attributes:
        topics: that will be sent if the receiver asks for their streams.
        recorded: all that a device may send; more than `topics` where the user has chosen.
        surplus: names of custom topics beyond those that one device may have.
    """

    topics: tuple[Topic, ...]
    recorded: tuple[Topic, ...]
    surplus: tuple[str, ...]
    _entries: Mapping[str, StreamEntry]
    _custom: str

    @classmethod
    def of(cls, reader: BagReader, table: StreamTable, chosen: Sequence[str] = ()) -> "Repertoire":
        """That of a recording.

        Args:
            chosen: names of topics, with or without their prefix; none means all.

        Raises:
            RecordingError: a chosen topic is not in the recording.
        """
        custom = _custom_topics(reader, table)
        most = table.custom_topics.max_topics
        recorded = (*_table_topics(reader, table), *custom[:most])
        names = {topic: {topic.name, topic.full_name(reader.prefix)} for topic in recorded}
        if unknown := [*{*chosen}.difference(*names.values())]:
            has = ", ".join(topic.name for topic in recorded)
            raise RecordingError(f"the recording has no topic {unknown[0]}; it has {has}")
        return cls(
            tuple(it for it in recorded if not chosen or names[it] & {*chosen}),
            recorded,
            tuple(topic.name for topic in custom[most:]),
            reader.config.streams,
            table.custom_topics.stream,
        )

    @property
    def streams(self) -> list[str]:
        """The streams that have topics."""
        return list(dict.fromkeys(topic.stream for topic in self.topics))

    def answers(self, request: Request) -> dict[str, StreamAnswer]:
        """One answer for each stream asked for."""
        return {id: self._answer(request, id) for id in request}

    def announced(self, request: Request) -> list[Topic]:
        """The topics that will be sent."""
        return [
            topic
            for topic in self.topics
            if topic.stream in request
            and (topic.when is None or topic.when.holds(request[topic.stream]))
        ]

    def _answer(self, request: Request, id: str) -> StreamAnswer:
        asked, has_some = request[id], any(topic.stream == id for topic in self.topics)
        # An app may have topics of its own, and need not.
        if not has_some and id != self._custom:
            is_left_out = any(topic.stream == id for topic in self.recorded)
            return StreamAnswer("refused", None, LEFT_OUT if is_left_out else _MISSING)
        entry = self._entries.get(id)
        if entry is None or entry.values is None or entry.values == asked:
            return StreamAnswer("applied", asked)
        return StreamAnswer("adjusted", entry.values, _DIFFERENT)


def _table_topics(reader: BagReader, table: StreamTable) -> list[Topic]:
    return [
        topic
        for stream in table.streams.values()
        for topic in stream.topics
        if reader.types.get(topic.full_name(reader.prefix)) == topic.type
    ]


def _custom_topics(reader: BagReader, table: StreamTable) -> list[Topic]:
    names = {name.removeprefix(f"{reader.prefix}/"): type for name, type in reader.types.items()}
    found = (table.custom_topics.topic(name, type) for name, type in names.items())
    return [topic for topic in found if topic is not None]
