"""The topics of a recording, and its answers to a configuration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ml2_receiver.errors import RecordingError
from ml2_receiver.session.streams import Request
from ml2_receiver.table.stream_table import Condition, StreamTable, Topic
from ml2_receiver.topics.config_topic import StreamEntry
from ml2_receiver.wire.messages import StreamAnswer

from ..bags.bag_reader import BagReader

_MISSING = "the recording does not have it"
LEFT_OUT = "--topics leaves it out"
_DIFFERENT = "recorded with these values"


@dataclass(frozen=True)
class Repertoire:
    """The topics of a recording that can be played.

    Attributes:
        topics: the topics that are sent if the receiver requests their streams.
        recorded: all topics that a device may send, also those that the user left out.
        surplus: the names of custom topics beyond the limit for one device.
    """

    topics: tuple[Topic, ...]
    recorded: tuple[Topic, ...]
    surplus: tuple[str, ...]
    _entries: Mapping[str, StreamEntry]
    _custom: str

    @classmethod
    def of(cls, reader: BagReader, table: StreamTable, chosen: Sequence[str] = ()) -> "Repertoire":
        """Returns the repertoire of a recording.

        Args:
            chosen: names of topics, with or without their prefix; empty means all.

        Raises:
            RecordingError: a chosen topic is not in the recording.
        """
        custom = _custom_topics(reader, table)
        limit = table.custom_topics.max_topics
        recorded = (*_table_topics(reader, table), *custom[:limit])
        names = {topic: {topic.name, topic.full_name(reader.prefix)} for topic in recorded}
        if unknown := [*{*chosen}.difference(*names.values())]:
            available = ", ".join(topic.name for topic in recorded)
            raise RecordingError(f"the recording has no topic {unknown[0]}; it has {available}")
        return cls(
            tuple(it for it in recorded if not chosen or names[it] & {*chosen}),
            recorded,
            tuple(topic.name for topic in custom[limit:]),
            reader.config.streams,
            table.custom_topics.stream,
        )

    @property
    def streams(self) -> list[str]:
        """The streams that have topics."""
        return list(dict.fromkeys(topic.stream for topic in self.topics))

    def answers(self, request: Request) -> dict[str, StreamAnswer]:
        """Returns an answer for each requested stream."""
        return {id: self._answer(request, id) for id in request}

    def announced(self, request: Request) -> list[Topic]:
        """Returns the topics that are sent for a request."""
        return [
            topic
            for topic in self.topics
            if topic.stream in request
            and not self._lacking(request, topic.stream)
            and (topic.when is None or topic.when.holds(request[topic.stream]))
        ]

    def _lacking(self, request: Request, id: str) -> tuple[Condition, ...]:
        """Returns the conditions of a stream's images, if the request meets none of them."""
        conditions = self._conditions(id)
        return () if any(it.holds(request[id]) for it in conditions) else conditions

    def _conditions(self, id: str) -> tuple[Condition, ...]:
        images = [it for it in self.topics if it.stream == id and it.role == "image"]
        return tuple(it.when for it in images if it.when is not None)

    def _answer(self, request: Request, id: str) -> StreamAnswer:
        requested, has_topics = request[id], any(topic.stream == id for topic in self.topics)
        # Custom topics are optional: the stream is applied without any, too.
        if not has_topics and id != self._custom:
            is_left_out = any(topic.stream == id for topic in self.recorded)
            return StreamAnswer("refused", None, LEFT_OUT if is_left_out else _MISSING)
        # A receiver takes no topic whose condition its request does not meet.
        if lacking := self._lacking(request, id):
            key, value = lacking[0]
            reason = f"recorded with {key} {value}, requested with {requested.get(key)}"
            return StreamAnswer("refused", None, reason)
        entry = self._entries.get(id)
        if entry is None or entry.values is None:
            return StreamAnswer("applied", requested)
        # If the format changed while it was recorded, the images of the requested one are sent.
        values = {**entry.values, **{key: requested[key] for key, _ in self._conditions(id)}}
        if values == requested:
            return StreamAnswer("applied", requested)
        return StreamAnswer("adjusted", values, _DIFFERENT)


def _table_topics(reader: BagReader, table: StreamTable) -> list[Topic]:
    return [
        topic
        for stream in table.streams.values()
        for topic in stream.topics
        if reader.types.get(topic.full_name(reader.prefix)) == topic.type
    ]


def _custom_topics(reader: BagReader, table: StreamTable) -> list[Topic]:
    # Absolute names in a recording are rarely those of an app
    own = f"{reader.prefix}/"
    names = {it.removeprefix(own): type for it, type in reader.types.items() if it.startswith(own)}
    found = (table.custom_topics.topic(name, type) for name, type in names.items())
    return [topic for topic in found if topic is not None]
