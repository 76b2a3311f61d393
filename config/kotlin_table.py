"""The stream table as Kotlin source."""

from collections.abc import Iterable
from dataclasses import dataclass

from ml2_receiver.table.stream_table import CustomTopics, Mode, Stream, StreamTable, Topic
from ml2_receiver.wire.json_body import Scalar
from stream_summary import stream_summary

_MAX_LINE = 120
_INDENT = " " * 4


@dataclass(frozen=True)
class Call:
    """A call expression; its arguments stand in lines of their own where one is too short."""

    name: str
    arguments: "tuple[Call | str, ...]"

    def on_one_line(self) -> str:
        return f"{self.name}({', '.join(_on_one_line(argument) for argument in self.arguments)})"

    def render(self, indent: str) -> str:
        line = self.on_one_line()
        if len(indent) + len(line) < _MAX_LINE:
            return line
        inner = indent + _INDENT
        lines = (f"{inner}{_render(argument, inner)},\n" for argument in self.arguments)
        return f"{self.name}(\n{''.join(lines)}{indent})"


def kotlin_table(table: StreamTable) -> str:
    properties = [_property(table, stream) for stream in table.streams.values()]
    custom = table.custom_topics
    names = _list(_camel(id) for id in table.streams).render(_INDENT * 2)
    return f"""package dev.ml2sensors.table

/** The streams of config/streams.yaml; generated from it by config/generate.py. */
public object StreamTable {{
    /** The REP-103 frame that poses are in. */
    public const val WORLD_FRAME: String = {_text(table.world_frame)}

    /** The body frame of the headset. */
    public const val HEAD_FRAME: String = {_text(table.head_frame)}

    /** Everything that is small. */
    internal val sensorsLane: QueueSpec = QueueSpec({table.lanes["sensors"].queue_frames})

    /** One per image stream. */
    internal val imageLane: QueueSpec = QueueSpec({table.lanes["image"].queue_frames})

{"\n\n".join(properties)}

    /** Of the topics of [{_camel(custom.stream)}]. */
    internal val customTopics: CustomTopicsSpec =
        {_custom(custom)}

    /** In the order of the file. */
    public val all: List<StreamSpec> =
        {names}

    /** Null where the table has no such stream. */
    public fun byId(id: String): StreamSpec? = all.firstOrNull {{ it.id == id }}
}}
"""


def _custom(custom: CustomTopics) -> str:
    texts = map(_text, (custom.role, custom.lane, custom.qos))
    return Call("CustomTopicsSpec", (*texts, str(custom.max_topics))).on_one_line()


def _property(table: StreamTable, stream: Stream) -> str:
    section = table.sections[stream.section]
    encodings = [topic.encoding for topic in stream.topics if topic.role == "image"]
    spec = Call(
        "StreamSpec",
        (
            _text(stream.id),
            _text(stream.section),
            _list(_topic(topic) for topic in stream.topics),
            _text(stream.frame),
            _text(stream.body_frame),
            _text(encodings[0] if encodings else None),
            _list(map(_text, section.permissions)),
            _list(map(_text, stream.backends)),
            _list(map(_mode, section.modes)),
        ),
    )
    declaration = f"{_INDENT}public val {_camel(stream.id)}: StreamSpec ="
    doc = f"{_INDENT}/** {stream_summary(table, stream)} */"
    return f"{doc}\n{declaration}\n{_INDENT * 2}{spec.render(_INDENT * 2)}"


def _topic(topic: Topic) -> Call:
    own_encoding = None if topic.role == "image" else topic.encoding
    when = topic.when and f"{topic.when.key}={_literal(topic.when.value)}"
    fields = (topic.role, topic.name, topic.type, topic.lane, topic.qos, own_encoding, when)
    return Call("TopicSpec", tuple(map(_text, fields)))


def _mode(mode: Mode) -> Call:
    return Call(
        "Mode",
        (
            str(mode.stream),
            _list(map(_text, mode.formats)),
            _list(map(str, mode.rates)),
            _list(f"{width} to {height}" for width, height in mode.resolutions),
            Call("mapOf", tuple(f"{rate} to {actual}" for rate, actual in mode.delivers.items())),
        ),
    )


def _list(items: "Iterable[Call | str]") -> Call:
    return Call("listOf", tuple(items))


def _camel(id: str) -> str:
    first, *rest = id.split("_")
    return first + "".join(word.capitalize() for word in rest)


def _literal(value: Scalar) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _text(value: str | None) -> str:
    return "null" if value is None else f'"{value}"'


def _on_one_line(expression: Call | str) -> str:
    return expression if isinstance(expression, str) else expression.on_one_line()


def _render(expression: Call | str, indent: str) -> str:
    return expression if isinstance(expression, str) else expression.render(indent)
