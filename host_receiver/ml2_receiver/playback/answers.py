"""What a recording answers to a configuration."""

from collections.abc import Iterator, Mapping

from ..configuration.table import Scalar, Stream, StreamTable, Topic
from ..link.streams import Request
from ..recording.bag_reader import BagReader
from ..wire.messages import StreamAnswer

_MISSING = StreamAnswer("refused", None, "the recording does not have it")
_DIFFERENT = "recorded so"


def recorded_streams(reader: BagReader, table: StreamTable) -> list[str]:
    """The streams that the recording has topics of."""
    return [stream.id for stream in table.streams.values() if any(_recorded(reader, stream))]


def answer(request: Request, reader: BagReader, table: StreamTable) -> dict[str, StreamAnswer]:
    """One answer for each stream asked for."""
    return {id: _answer(reader, table, id, values) for id, values in request.items()}


def announced(request: Request, reader: BagReader, table: StreamTable) -> list[Topic]:
    """The topics that will be sent."""
    return [
        topic
        for id, values in request.items()
        if id in table.streams
        for topic in _recorded(reader, table.streams[id])
        if topic.when is None or topic.when.holds(values)
    ]


def _recorded(reader: BagReader, stream: Stream) -> Iterator[Topic]:
    for topic in stream.topics:
        if reader.types.get(topic.full_name(reader.prefix)) == topic.type:
            yield topic


def _answer(
    reader: BagReader, table: StreamTable, id: str, asked: Mapping[str, Scalar]
) -> StreamAnswer:
    if id not in table.streams or not any(_recorded(reader, table.streams[id])):
        return _MISSING
    entry = reader.config.streams.get(id)
    if entry is None or entry.values is None or entry.values == asked:
        return StreamAnswer("applied", asked)
    return StreamAnswer("adjusted", entry.values, _DIFFERENT)
