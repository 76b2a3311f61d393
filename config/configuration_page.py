"""The page that lists every key of config.yaml and every stream."""

from collections.abc import Iterable, Iterator

from ml2_receiver.table.stream_table import Key, Section, Stream, StreamTable, Topic
from ml2_receiver.wire.json_body import Scalar

_INTRODUCTION = """# Configuration

`config/config.yaml` is a ROS 2 parameter file: sections of keys under `/ml2_receiver:` and
`ros__parameters:`. A key that is not there has its default. `ml2-receiver config check FILE` says
what is wrong in a file, or which topics it starts.

This page is generated from `config/streams.yaml` by `config/generate.py`.
"""

_MODES = """\
Stream, resolution, rate and format of a camera are legal together when one row has them.
"""

_STREAMS = """\
Topics are under the prefix `general.topic_name`, except those with a leading slash. Publishers are
reliable, volatile but for `/tf_static`, which is transient local, and keep as many messages as the
depth says. Which values start a stream stands in the last column; the transform tree runs whenever
another stream does.
"""


_BACKENDS = """\
Interfaces of the device that can serve a stream. The first is the default; where there is a choice,
the section's key `backend` makes it.
"""


_PERMISSIONS = """\
What the manifest of an app must declare for the streams it wants; a dangerous permission must also
be requested from the user. Streams that are not listed need none. A stream whose permission is not
granted is refused, and the refusal names it.
"""


def configuration_page(table: StreamTable) -> str:
    return "\n".join(
        [
            _INTRODUCTION,
            "## Keys\n",
            *_table("section|key|type|allowed|default|topics it switches on|meaning", _keys(table)),
            "\n## Camera modes\n",
            _MODES,
            *_table("section|stream|resolution|rate in Hz|format", _modes(table)),
            "\n## Streams\n",
            _STREAMS,
            *_table("stream|topic|type|encoding|frame|body frame|depth|runs when", _topics(table)),
            "\n## Backends\n",
            _BACKENDS,
            *_table("streams|backend|why it has this place", _backends(table)),
            "\n## Permissions\n",
            _PERMISSIONS,
            *_table("streams|Android permission|protection", _permissions(table)),
            "\n## Topics of the receiver itself\n",
            *_table("topic|type|depth|durability", _receiver_topics(table)),
            "",
        ]
    )


def _table(header: str, rows: Iterable[Iterable[str]]) -> Iterator[str]:
    columns = header.split("|")
    yield f"| {' | '.join(columns)} |"
    yield f"|{'---|' * len(columns)}"
    for row in rows:
        yield f"| {' | '.join(row)} |"


def _keys(table: StreamTable) -> Iterator[tuple[str, ...]]:
    for section in table.sections.values():
        for key in section.keys.values():
            meaning = key.doc
            if key is next(iter(section.keys.values())):
                meaning = " ".join(filter(None, (section.doc, meaning)))
            yield (
                section.id,
                f"`{key.name}`",
                key.type,
                _allowed(key),
                f"`{_yaml(key.default)}`",
                ", ".join(f"`{name}`" for name in _switched_topics(table, section, key)),
                meaning,
            )


def _allowed(key: Key) -> str:
    if key.type == "bool":
        return "true, false"
    if key.type == "file":
        return "the name of a file, or nothing"
    if key.type == "topic":
        return "a ROS 2 topic name"
    if key.allowed:
        return ", ".join(map(str, key.allowed))
    return "any" if key.minimum is None else f"at least {key.minimum}"


def _switched_topics(table: StreamTable, section: Section, key: Key) -> list[str]:
    return [
        topic.name
        for stream in table.streams.values()
        if stream.section == section.id
        for topic in stream.topics
        if _is_switched(topic, stream, key)
    ]


def _is_switched(topic: Topic, stream: Stream, key: Key) -> bool:
    if topic.when is not None:
        return topic.when.key == key.name
    return key.type == "bool" and key.name in (stream.when or {})


def _modes(table: StreamTable) -> Iterator[tuple[str, ...]]:
    for section in table.sections.values():
        for mode in section.modes:
            rates = (
                f"{rate} (delivers {mode.delivers[rate]})" if rate in mode.delivers else str(rate)
                for rate in mode.rates
            )
            yield (
                section.id,
                str(mode.stream),
                ", ".join(f"{width}x{height}" for width, height in mode.resolutions),
                ", ".join(rates),
                ", ".join(mode.formats),
            )


def _topics(table: StreamTable) -> Iterator[tuple[str, ...]]:
    for stream in table.streams.values():
        for topic in stream.topics:
            conditions = dict([*(stream.when or {}).items(), *filter(None, [topic.when])])
            yield (
                stream.id,
                f"`{topic.name}`",
                topic.type,
                topic.encoding or "",
                topic.frame,
                stream.body_frame or "",
                str(table.qos[topic.qos].depth),
                ", ".join(
                    f"`{stream.section}.{key}: {_yaml(value)}`" for key, value in conditions.items()
                ),
            )


def _backends(table: StreamTable) -> Iterator[tuple[str, ...]]:
    groups: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for stream in table.streams.values():
        groups.setdefault(tuple(stream.backends.items()), []).append(stream.id)
    for backends, streams in groups.items():
        for name, reason in backends:
            yield ", ".join(streams), name, reason


def _permissions(table: StreamTable) -> Iterator[tuple[str, ...]]:
    for permission, protection in table.permissions.items():
        needing = [
            stream.id
            for stream in table.streams.values()
            if permission in table.sections[stream.section].permissions
        ]
        yield ", ".join(needing), f"`{permission}`", protection


def _yaml(value: Scalar) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _receiver_topics(table: StreamTable) -> Iterator[tuple[str, ...]]:
    for topic in table.receiver_topics:
        qos = table.qos[topic.qos]
        yield f"`{topic.name}`", topic.type, str(qos.depth), qos.durability
