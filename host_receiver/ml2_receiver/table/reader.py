"""Reads the stream table and checks that it is consistent."""

import functools
from collections.abc import Callable, Collection, Iterator, Mapping
from importlib import resources
from types import MappingProxyType
from typing import Any

import yaml

from ..errors import TableError
from ..wire.json_body import Scalar
from ..wire.kinds import Lane
from .stream_table import (
    CAMERA_KEYS,
    MESSAGE_TYPE,
    VIDEO,
    Adaptation,
    Condition,
    CustomTopics,
    ImageSizes,
    Key,
    LaneClass,
    Mode,
    Pace,
    Qos,
    ReceiverTopic,
    Section,
    Stream,
    StreamTable,
    Topic,
)

Row = Mapping[str, Any]

# libyaml's loader if PyYAML has it, which saves every program 60 ms.
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_KEY_TYPES = ("bool", "file", "integer", "line", "link", "names", "number", "topic")


@functools.cache
def load_table() -> StreamTable:
    """Returns the table that this package was built with.

    Raises:
        TableError: the table contradicts itself.
    """
    text = resources.files("ml2_receiver").joinpath("data/streams.yaml").read_text("utf-8")
    return read_table(yaml.load(text, _Loader))


def read_table(document: Row) -> StreamTable:
    """Returns the table in a parsed streams.yaml.

    Raises:
        TableError: a row is wrong; the message names it and the legal values.
    """
    try:
        _one_of("schema", document["schema"], [1])
        permissions = _each(document["permissions"], _protection)
        sections = _each(document["sections"], lambda id, row: _section(id, row, permissions))
        classes = _each(document["lanes"], lambda name, row: LaneClass(name, **row))
        streams = _each(
            document["streams"], lambda id, row: _stream(id, row, document, sections, classes)
        )
        custom_topics = _custom_topics(document["custom_topics"], document, classes)
        _distinct([topic.name for stream in streams.values() for topic in stream.topics])
        return StreamTable(
            streams=streams,
            sections=sections,
            permissions=permissions,
            qos=_each(document["qos"], lambda _, row: Qos(**row)),
            lane_classes=classes,
            lanes=_lanes(custom_topics, streams),
            adaptation=_adaptation(document["adaptation"], streams),
            image_sizes=_image_sizes(document["image_sizes"], sections),
            custom_topics=custom_topics,
            receiver_topics=tuple(ReceiverTopic(**row) for row in document["receiver_topics"]),
            world_frame=document["frames"]["world"],
            head_frame=document["frames"]["head"],
        )
    except KeyError as error:
        raise TableError(f"{error} is missing") from error
    except (AttributeError, TypeError, ValueError) as error:
        raise TableError(str(error)) from error


def _each[T](rows: Row, build: Callable[[str, Any], T]) -> Mapping[str, T]:
    return MappingProxyType({id: _named(id, build, id, row) for id, row in rows.items()})


def _named[T](name: str, build: Callable[..., T], *arguments: Any) -> T:
    """Returns what `build` returns; its errors get the prefix `name`."""
    try:
        return build(*arguments)
    except KeyError as error:
        raise ValueError(f"{name}: {error} is missing") from error
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(f"{name}: {error}") from error


def _one_of(label: str, value: object, allowed: Collection[object]) -> None:
    if value not in allowed:
        raise ValueError(f"{label}: expected one of {', '.join(map(str, allowed))}, found {value}")


def _distinct(names: list[str]) -> None:
    duplicates = sorted({name for name in names if names.count(name) > 1})
    if duplicates:
        raise ValueError(f"topics of more than one stream: {', '.join(duplicates)}")


def _lanes(custom: CustomTopics, streams: Mapping[str, Stream]) -> Mapping[str, Lane]:
    lanes = {lane.name: lane for lane in custom.lanes}
    for lane in (topic.lane for stream in streams.values() for topic in stream.topics):
        if lanes.setdefault(lane.name, lane) != lane:
            raise ValueError(f"lane {lane.name}: expected topics of one class, found two")
    return MappingProxyType(lanes)


def _protection(_: str, protection: str) -> str:
    _one_of("protection", protection, ["dangerous", "normal"])
    return protection


def _section(id: str, row: Row, permissions: Collection[str]) -> Section:
    for permission in row.get("permissions", ()):
        _one_of("permission", permission, permissions)
    modes = tuple(_mode(**mode) for mode in row.get("modes", ()))
    keys = [*_camera_keys(modes, row["defaults"])] if modes else []
    keys += (_named(name, _key, name, key) for name, key in row.get("keys", {}).items())
    return Section(
        id=id,
        doc=row.get("doc", ""),
        permissions=tuple(row.get("permissions", ())),
        shows_eyes=row.get("shows_eyes", False),
        modes=modes,
        keys=MappingProxyType({key.name: key for key in keys}),
    )


def _mode(stream: int, formats: list[str], rates: list[int], resolutions: list[list[int]]) -> Mode:
    sizes = tuple((width, height) for width, height in resolutions)
    return Mode(stream, tuple(formats), tuple(rates), sizes)


def _camera_keys(modes: tuple[Mode, ...], defaults: Row) -> Iterator[Key]:
    def mode_key(name: str, type: str, values: set[Any], doc: str) -> Key:
        return Key(name, type, defaults[name], doc, allowed=tuple(sorted(values)))

    if not any(_allows(mode, defaults) for mode in modes):
        raise ValueError(f"defaults: expected the values of one mode, found {defaults}")
    sizes = {size for mode in modes for size in mode.resolutions}
    rates = {rate for mode in modes for rate in mode.rates}
    formats = {format for mode in modes for format in mode.formats}
    yield Key("enabled", "bool", defaults.get("enabled", False), "Publish it.")
    yield mode_key("stream", "integer", {mode.stream for mode in modes}, "Stream of the device.")
    yield mode_key("resolution_width", "integer", {width for width, _ in sizes}, "In pixels.")
    yield mode_key("resolution_height", "integer", {height for _, height in sizes}, "In pixels.")
    yield mode_key("update_rate", "integer", rates, "In Hz.")
    yield mode_key("format", "text", formats, "Of the images.")


def _allows(mode: Mode, values: Row) -> bool:
    return (
        values["stream"] == mode.stream
        and (values["resolution_width"], values["resolution_height"]) in mode.resolutions
        and values["update_rate"] in mode.rates
        and values["format"] in mode.formats
    )


def _key(name: str, row: Row) -> Key:
    if isinstance(row["type"], list):
        is_text = isinstance(row["default"], str)
        choice = {**row, "type": "text" if is_text else "integer", "allowed": tuple(row["type"])}
        _one_of("default", choice["default"], choice["allowed"])
        return Key(name, **choice)
    _one_of("type", row["type"], _KEY_TYPES)
    if row["type"] == "names":
        row = {**row, "default": " ".join(row["default"])}
    return Key(name, **row)


def _stream(
    id: str,
    row: Row,
    document: Row,
    sections: Mapping[str, Section],
    classes: Mapping[str, LaneClass],
) -> Stream:
    _one_of("section", row["section"], sections)
    _one_of("kind", row["kind"], document["kinds"])
    _one_of("kind under paces", row["kind"], document["paces"])
    section = sections[row["section"]]
    when = row.get("when", {"enabled": True})
    names = [*(CAMERA_KEYS if section.modes else ()), *row.get("values", ())]
    values = tuple(name if "." in name else f"{section.id}.{name}" for name in names)
    for dotted in values:
        owner, _, name = dotted.partition(".")
        _one_of("values", owner, sections)
        _one_of("values", name, sections[owner].keys)
    return Stream(
        id=id,
        section=section.id,
        when=None if when == "any_stream" else _condition(when, section),
        values=values,
        backends=_backends(row["backends"], document, section),
        topics=tuple(
            _topic(id, row, topic, document, classes) for topic in document["kinds"][row["kind"]]
        ),
        frame=row["frame"],
        body_frame=row.get("body_frame"),
        pace=Pace(**document["paces"][row["kind"]]),
    )


def _backends(name: str, document: Row, section: Section) -> Mapping[str, str]:
    _one_of("backends", name, document["backends"])
    backends: dict[str, str] = document["backends"][name]
    key = section.keys.get("backend")
    if key is not None and key.allowed != tuple(backends):
        raise ValueError(f"backend: expected {', '.join(backends)}, found {key.allowed}")
    return MappingProxyType(backends)


def _condition(when: Row, section: Section) -> Mapping[str, tuple[Scalar, ...]]:
    for name in when:
        _one_of("when", name, section.keys)
    return MappingProxyType(
        {name: tuple(it) if isinstance(it, list) else (it,) for name, it in when.items()}
    )


def _custom_topics(row: Row, document: Row, classes: Mapping[str, LaneClass]) -> CustomTopics:
    _one_of("stream", row["stream"], document["streams"])
    for name in row["lanes"]:
        _one_of("lane", name, classes)
    for name in row["qos"]:
        _one_of("qos", name, document["qos"])
    lanes = tuple(classes[name].lane(row["stream"]) for name in row["lanes"])
    return CustomTopics(**{**row, "lanes": lanes, "qos": tuple(row["qos"])})


def _adaptation(row: Row, streams: Collection[str]) -> Adaptation:
    groups = tuple(tuple(group) for group in row["streams"])
    for id in (id for group in groups for id in group):
        _one_of("adaptation", id, streams)
    steps = {name: tuple(row[name]) for name in ("quality", "rate_hz")}
    for name, values in steps.items():
        if sorted(values, reverse=True) != list(values) or min(values) < 1:
            raise ValueError(f"adaptation: expected {name} above 0 that falls, found {values}")
    first_round_hz = tuple(row["first_round_hz"])
    if len(first_round_hz) != len(groups) or not set(first_round_hz) <= set(steps["rate_hz"]):
        expected = f"expected one of rate_hz for each of {len(groups)} lines of streams"
        raise ValueError(f"adaptation: first_round_hz: {expected}, found {first_round_hz}")
    return Adaptation(groups, **steps, first_round_hz=first_round_hz)


def _image_sizes(row: Row, sections: Mapping[str, Section]) -> ImageSizes:
    bits, by_quality = row["bits_per_pixel"], row["jpeg_by_quality"]
    sizes = ImageSizes(MappingProxyType(dict(bits)), MappingProxyType(dict(by_quality)))
    modes = [mode for section in sections.values() for mode in section.modes]
    for format in {format for mode in modes for format in mode.formats}.difference(VIDEO):
        _one_of("image_sizes", format, sizes.bits_per_pixel)
    return sizes


def _topic_condition(when: Row, row: Row) -> Condition:
    ((key, value),) = when.items()
    _one_of("when", key, [*CAMERA_KEYS, *row.get("values", ())])
    return Condition(key, value)


def _topic(
    stream: str, row: Row, topic: Row, document: Row, classes: Mapping[str, LaneClass]
) -> Topic:
    _one_of("lane", topic["lane"], classes)
    _one_of("qos", topic["qos"], document["qos"])
    if not MESSAGE_TYPE.fullmatch(topic["type"]):
        raise ValueError(f"type: expected <package>/msg/<Name>, found {topic['type']}")
    suffix = topic.get("suffix", "")
    return Topic(
        stream=stream,
        role=topic["role"],
        name=suffix if suffix.startswith("/") else "/".join(filter(None, (row["topic"], suffix))),
        type=topic["type"],
        lane=classes[topic["lane"]].lane(stream),
        qos=topic["qos"],
        encoding=topic.get("encoding", row.get("encoding") if topic["role"] == "image" else None),
        when=_topic_condition(topic["when"], row) if "when" in topic else None,
        frame=row["frame"],
        pace=Pace() if topic["qos"] == "latched" else Pace(**document["paces"][row["kind"]]),
    )
