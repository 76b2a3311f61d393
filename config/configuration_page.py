"""The page that lists every key of config.yaml and every stream."""

from collections.abc import Iterable, Iterator, Sequence

from ml2_receiver.table.key_values import LINK_WORDS
from ml2_receiver.table.stream_table import (
    CAMERA_KEYS,
    Key,
    Section,
    Stream,
    StreamTable,
    Topic,
)
from ml2_receiver.wire.json_body import Scalar

_INTRODUCTION = """# Configuration

`config/config.yaml` is a ROS 2 parameter file: sections of keys under `/ml2_receiver:` and
`ros__parameters:`. It shows every key with its default. A key that your file leaves out has that
default, too: write only what you change. `ml2-receiver config check FILE` lists what is wrong in a
file, or the topics that it starts.

`config/generate.py` generates this page from `config/streams.yaml`. Sections with the same keys
share a table.
"""

_MODES = """\
Stream, resolution, rate and format of a camera must be in one row.
"""

_STREAMS = """\
Topics are under the prefix `general.topic_name`, except those with a leading slash. Publishers are
reliable and volatile, except `/tf_static`, which is transient local. *Depth* is the length of a
publisher's queue. The last column has the values that start a stream. The transform tree runs
whenever another stream does. `*` stands for each of the streams.
"""


_BACKENDS = """\
A backend is an interface of the device that can serve a stream. The first is the default. The
section's key `backend` chooses another where there is one.
"""


_PERMISSIONS = """\
An app must declare these permissions in its manifest for the streams that it uses. It must also
request a dangerous permission from the user. Other streams need no permission. A stream is refused
while its permission is not granted; the reason names the permission.
"""


def configuration_page(table: StreamTable) -> str:
    return "\n".join(
        [
            _INTRODUCTION,
            "## Keys\n",
            *_sections(table),
            "## Camera modes\n",
            _MODES,
            *_table("section|stream|resolution|rate in Hz|format", _modes(table)),
            "\n## Streams\n",
            _STREAMS,
            *_table("stream|topic|type|encoding|frame|body frame|depth|runs when", _topics(table)),
            "\n## Backends\n",
            _BACKENDS,
            *_table("streams|backend|reason for its rank", _backends(table)),
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


def _sections(table: StreamTable) -> Iterator[str]:
    """Yields a heading, sentences and a table for all sections that are alike but for defaults."""
    groups: dict[tuple[str, tuple[str, ...]], list[Section]] = {}
    for section in table.sections.values():
        groups.setdefault((section.doc, tuple(section.keys)), []).append(section)
    for (doc, names), sections in groups.items():
        yield f"### {', '.join(section.id for section in sections)}\n"
        yield from [f"{doc}\n"] if doc else []
        rows = (_row(sections, name) for name in names)
        yield from _table("key|type|allowed|default|meaning", rows)
        yield ""
        for key in sections[0].keys.values():
            topics = [it for section in sections for it in _switched_topics(table, section, key)]
            if topics:
                shown = ", ".join(f"`{name}`" for name in topics)
                yield f"<details><summary>Topics of <code>{key.name}</code></summary>\n"
                yield f"{shown}\n\n</details>\n"


def _row(sections: Sequence[Section], name: str) -> tuple[str, ...]:
    key = sections[0].keys[name]
    return f"`{name}`", key.type, _allowed(key), _defaults(sections, name), key.doc


def _defaults(sections: Sequence[Section], name: str) -> str:
    """Returns the default of a key, with the names of the sections where it differs."""
    having: dict[str, list[str]] = {}
    for section in sections:
        having.setdefault(f"`{_yaml(section.keys[name].default)}`", []).append(section.id)
    if len(having) == 1:
        return next(iter(having))
    return "; ".join(f"{', '.join(ids)}: {default}" for default, ids in having.items())


def _allowed(key: Key) -> str:
    if key.type == "bool":
        return "true, false"
    if key.type == "file":
        return "the name of a file, or nothing"
    if key.type == "line":
        return "at most 63 bytes in one line"
    if key.type == "link":
        return f"{', '.join(LINK_WORDS)}, or Mbit/s above 0"
    if key.type == "names":
        return "a list of names, or one text with spaces between them"
    if key.type == "topic":
        return "a ROS 2 topic name"
    if key.allowed:
        return ", ".join(map(str, key.allowed))
    if key.maximum is not None:
        return f"{key.minimum} to {key.maximum}"
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
    if topic.when is not None and topic.when.key == key.name:
        return True
    is_optional = topic.when is not None and topic.when.key not in CAMERA_KEYS
    return key.type == "bool" and key.name in (stream.when or {}) and not is_optional


def _modes(table: StreamTable) -> Iterator[tuple[str, ...]]:
    groups: dict[str, list[Section]] = {}
    for section in table.sections.values():
        groups.setdefault(repr(section.modes), []).append(section)
    for sections in groups.values():
        for mode in sections[0].modes:
            yield (
                ", ".join(section.id for section in sections),
                str(mode.stream),
                ", ".join(f"{width}x{height}" for width, height in mode.resolutions),
                ", ".join(map(str, mode.rates)),
                ", ".join(mode.formats),
            )


def _topics(table: StreamTable) -> Iterator[tuple[str, ...]]:
    groups: dict[tuple[str, ...], list[str]] = {}
    for stream in table.streams.values():
        for topic in stream.topics:
            conditions = dict(stream.when or {})
            if topic.when is not None:
                conditions[topic.when.key] = (topic.when.value,)
            row: tuple[str, ...] = (
                f"`{topic.name}`",
                topic.type,
                topic.encoding or "",
                f"`{topic.frame}`",
                f"`{stream.body_frame}`" if stream.body_frame else "",
                str(table.qos[topic.qos].depth),
                ", ".join(
                    " or ".join(f"`{stream.section}.{key}: {_yaml(it)}`" for it in values)
                    for key, values in conditions.items()
                ),
            )
            shared = tuple(cell.replace(stream.id, "*") for cell in row)
            groups.setdefault(shared if stream.id in topic.name else row, []).append(stream.id)
    for row, streams in groups.items():
        cells = row if len(streams) > 1 else (cell.replace("*", streams[0]) for cell in row)
        yield ", ".join(streams), *cells


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
