"""The stream table as Kotlin source."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from ml2_receiver.table.stream_table import (
    Adaptation,
    CustomTopics,
    LaneClass,
    Mode,
    Stream,
    StreamTable,
    Topic,
)
from ml2_receiver.wire.json_body import Scalar
from ml2_receiver.wire.kinds import Lane
from stream_summary import stream_summary

_MAX_LINE = 120
_INDENT = " " * 4


@dataclass(frozen=True)
class Named:
    """An argument with its name."""

    name: str
    value: "Call | str"

    def on_one_line(self) -> str:
        return f"{self.name} = {_on_one_line(self.value)}"

    def render(self, indent: str) -> str:
        if len(indent) + len(self.on_one_line()) < _MAX_LINE:
            return self.on_one_line()
        return f"{self.name} = {_render(self.value, indent)}"


@dataclass(frozen=True)
class Call:
    """A call expression; its arguments stand in lines of their own where one is too short."""

    name: str
    arguments: "tuple[Call | Named | str, ...]"

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
    lane_classes = "\n\n".join(map(_lane_class, table.lane_classes.values()))
    names = _list(_camel(id) for id in table.streams).render(_INDENT * 2)
    return f"""package dev.ml2sensors.table

/** The streams of config/streams.yaml; generated from it by config/generate.py. */
public object StreamTable {{
    /** The REP-103 frame that poses are in. */
    public const val WORLD_FRAME: String = {_text(table.world_frame)}

    /** The body frame of the headset. */
    public const val HEAD_FRAME: String = {_text(table.head_frame)}

{lane_classes}

{"\n\n".join(properties)}

    /** The order in which images give way to the link. */
    internal val adaptation: AdaptationSpec =
        {_adaptation(table.adaptation).render(_INDENT * 2)}

    /** The size of a JPEG by its quality, relative to that at quality 80. */
    internal val jpegSizes: Map<Int, Double> =
        {_sizes(table.image_sizes.jpeg_by_quality).on_one_line()}

    /** The rules for topics of [{_camel(custom.stream)}]. */
    internal val customTopics: CustomTopicsSpec =
        {_custom(custom)}

    /** All streams, in the order of the file. */
    public val all: List<StreamSpec> =
        {names}

    /** Returns the stream with this [id], or null if there is none. */
    public fun byId(id: String): StreamSpec? = all.firstOrNull {{ it.id == id }}
}}
"""


def _lane_class(lane_class: LaneClass) -> str:
    lanes = "The lane" if lane_class.is_shared else "The lanes"
    value = _call(
        "LaneClass",
        name=_text(lane_class.name),
        isShared=_literal(lane_class.is_shared),
        isPaced=_literal(lane_class.is_paced),
        queueFrames=str(lane_class.queue_frames),
        maxPayloadBytes=str(lane_class.max_payload_bytes),
    )
    return f"""    /** {lanes} of the class `{lane_class.name}`. */
    internal val {lane_class.name}Lane: LaneClass =
        {value.render(_INDENT * 2)}"""


def _adaptation(adaptation: Adaptation) -> Call:
    groups = (_list(map(_text, group)) for group in adaptation.streams)
    return _call(
        "AdaptationSpec",
        streams=_list(groups),
        qualities=_list(map(str, adaptation.quality)),
        ratesHz=_list(map(str, adaptation.rate_hz)),
        firstRoundHz=_list(map(str, adaptation.first_round_hz)),
    )


def _sizes(by_quality: Mapping[int, float]) -> Call:
    return Call("mapOf", tuple(f"{it} to {float(size)}" for it, size in by_quality.items()))


def _custom(custom: CustomTopics) -> str:
    return _call(
        "CustomTopicsSpec",
        role=_text(custom.role),
        small=_lane_class_of(custom.lanes[0]),
        large=_lane_class_of(custom.lanes[1]),
        qos=_text(custom.qos[0]),
        latchedQos=_text(custom.qos[1]),
        maxTopics=str(custom.max_topics),
    ).render(_INDENT * 2)


def _property(table: StreamTable, stream: Stream) -> str:
    section = table.sections[stream.section]
    encodings = [topic.encoding for topic in stream.topics if topic.role == "image"]
    spec = _call(
        "StreamSpec",
        id=_text(stream.id),
        section=_text(stream.section),
        topics=_list(_topic(topic, encodings[:1]) for topic in stream.topics),
        frameId=_text(stream.frame),
        bodyFrameId=_text(stream.body_frame),
        encoding=_text(encodings[0] if encodings else None),
        permissions=_list(map(_text, section.permissions)),
        backends=_list(map(_text, stream.backends)),
        modes=_list(map(_mode, section.modes)),
        showsEyes=_literal(True) if section.shows_eyes else "null",
        longestPauseSeconds=_number(stream.pace.longest_pause_s),
    )
    declaration = f"{_INDENT}public val {_camel(stream.id)}: StreamSpec ="
    doc = f"{_INDENT}/** {stream_summary(table, stream)} */"
    return f"{doc}\n{declaration}\n{_INDENT * 2}{spec.render(_INDENT * 2)}"


def _topic(topic: Topic, encodings_of_stream: list[str | None]) -> Call:
    own_encoding = None if topic.encoding in encodings_of_stream else topic.encoding
    when = topic.when and f"{topic.when.key}={_literal(topic.when.value)}"
    return _call(
        "TopicSpec",
        role=_text(topic.role),
        name=_text(topic.name),
        type=_text(topic.type),
        lane=_text(topic.lane.name),
        laneClass=_lane_class_of(topic.lane),
        qos=_text(topic.qos),
        encoding=_text(own_encoding),
        condition=_text(when),
    )


def _lane_class_of(lane: Lane) -> str:
    return f"{str(lane.kind.name).lower()}Lane"


def _mode(mode: Mode) -> Call:
    return _call(
        "Mode",
        stream=str(mode.stream),
        formats=_list(map(_text, mode.formats)),
        rates=_list(map(str, mode.rates)),
        resolutions=_list(f"{width} to {height}" for width, height in mode.resolutions),
    )


def _call(name: str, /, **arguments: "Call | str") -> Call:
    """A call whose arguments are named; those that are null or empty are left to their defaults."""
    given = {
        key: value for key, value in arguments.items() if value != "null" and not _is_empty(value)
    }
    return Call(name, tuple(Named(key, value) for key, value in given.items()))


def _is_empty(value: "Call | str") -> bool:
    return isinstance(value, Call) and not value.arguments


def _list(items: "Iterable[Call | str]") -> Call:
    return Call("listOf", tuple(items))


def _camel(id: str) -> str:
    first, *rest = id.split("_")
    return first + "".join(word.capitalize() for word in rest)


def _literal(value: Scalar) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _number(value: int | None) -> str:
    return "null" if value is None else str(value)


def _text(value: str | None) -> str:
    return "null" if value is None else f'"{value}"'


def _on_one_line(expression: Call | Named | str) -> str:
    return expression if isinstance(expression, str) else expression.on_one_line()


def _render(expression: Call | Named | str, indent: str) -> str:
    return expression if isinstance(expression, str) else expression.render(indent)
