"""Lists the options of each stream, for people and for scripts."""

from collections.abc import Mapping
from typing import Any

from rich.table import Table

from ..table.key_values import LINK_WORDS
from ..table.stream_table import CAMERA_KEYS, Key, Mode, Stream, StreamTable
from ..wire.json_body import Scalar

type StreamOptions = Mapping[str, Mapping[str, Any]]


def options_of(table: StreamTable) -> StreamOptions:
    """Per stream: `when` it runs, legal `modes` of a camera, other `keys`, all by their names in
    config.yaml, its `topics` and the `permissions` it needs."""
    return {stream.id: _options(stream, table) for stream in table.streams.values()}


def _options(stream: Stream, table: StreamTable) -> dict[str, Any]:
    section = table.sections[stream.section]
    when = {f"{section.id}.{key}": _one_or_list(it) for key, it in (stream.when or {}).items()}
    by_name = {
        f"{s.id}.{key.name}": key for s in table.sections.values() for key in s.keys.values()
    }
    keys = {
        name: _key(by_name[name])
        for name in stream.values
        if not (section.modes and name.rpartition(".")[2] in CAMERA_KEYS)
    }
    return {
        "when": when,
        "modes": [_mode(mode) for mode in section.modes if _is_of(mode, stream)],
        "keys": keys,
        "topics": [topic.name for topic in stream.topics],
        "permissions": list(section.permissions),
    }


def _is_of(mode: Mode, stream: Stream) -> bool:
    when = stream.when or {}
    return mode.stream in when.get("stream", (mode.stream,))


def _mode(mode: Mode) -> dict[str, Any]:
    return {
        "stream": mode.stream,
        "resolutions": [f"{width}x{height}" for width, height in mode.resolutions],
        "update_rates": list(mode.rates),
        "formats": list(mode.formats),
    }


def _key(key: Key) -> dict[str, Any]:
    limits: dict[str, Any] = {"allowed": list(key.allowed)} if key.allowed else {}
    range = {"minimum": key.minimum, "maximum": key.maximum}
    limits |= {name: limit for name, limit in range.items() if limit is not None}
    return {"type": key.type, "default": key.default, **limits}


def other_options(table: StreamTable) -> Mapping[str, Mapping[str, Any]]:
    """Returns the keys of the sections that have no stream, by their names in config.yaml."""
    sections = {stream.section for stream in table.streams.values()}
    return {
        f"{section.id}.{key.name}": _key(key)
        for section in table.sections.values()
        if section.id not in sections
        for key in section.keys.values()
    }


def options_table(streams: StreamOptions, others: Mapping[str, Mapping[str, Any]]) -> Table:
    """A row per stream, and one with the keys of `others`."""
    table = Table("stream", "runs when", "legal values", show_lines=True)
    for id, options in streams.items():
        when = "\n".join(f"{name}: {_words(values)}" for name, values in options["when"].items())
        modes = [
            f"stream {mode['stream']}: {', '.join(mode['resolutions'])}"
            f" at {', '.join(map(str, mode['update_rates']))} Hz, {', '.join(mode['formats'])}"
            for mode in options["modes"]
        ]
        keys = [f"{name}: {_values(key)}" for name, key in options["keys"].items()]
        table.add_row(id, when or "any other runs", "\n".join([*modes, *keys]))
    keys = [f"{name}: {_values(key)}" for name, key in others.items()]
    table.add_row("all streams", "", "\n".join(keys))
    return table


def _values(key: Mapping[str, Any]) -> str:
    if key["type"] == "link":
        return f"{', '.join(LINK_WORDS)}, or Mbit/s above 0"
    if "allowed" in key:
        return ", ".join(map(str, key["allowed"]))
    if "maximum" in key:
        return f"{key['minimum']:g} to {key['maximum']:g}"
    if "minimum" in key:
        return f"{key['type']} of at least {key['minimum']:g}"
    return "true, false" if key["type"] == "bool" else str(key["type"])


def _one_or_list(values: tuple[Scalar, ...]) -> Scalar | list[Scalar]:
    return values[0] if len(values) == 1 else list(values)


def _words(values: Scalar | list[Scalar]) -> str:
    words = values if isinstance(values, list) else [values]
    return " or ".join(str(it).lower() if isinstance(it, bool) else str(it) for it in words)
