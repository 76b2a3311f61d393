"""Lists the options of each stream, for people and for scripts."""

from collections.abc import Mapping
from typing import Any

from rich.table import Table

from ..table.stream_table import CAMERA_KEYS, Key, Mode, Stream, StreamTable

type StreamOptions = Mapping[str, Mapping[str, Any]]


def options_of(table: StreamTable) -> StreamOptions:
    """Per stream: `when` it runs, legal `modes` of a camera, other `keys`, all by their names in
    config.yaml, its `topics` and the `permissions` it needs."""
    return {stream.id: _options(stream, table) for stream in table.streams.values()}


def _options(stream: Stream, table: StreamTable) -> dict[str, Any]:
    section = table.sections[stream.section]
    when = {f"{section.id}.{key}": value for key, value in (stream.when or {}).items()}
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
    return when.get("stream", mode.stream) == mode.stream


def _mode(mode: Mode) -> dict[str, Any]:
    return {
        "stream": mode.stream,
        "resolutions": [f"{width}x{height}" for width, height in mode.resolutions],
        "update_rates": list(mode.rates),
        "formats": list(mode.formats),
    }


def _key(key: Key) -> dict[str, Any]:
    limits = {"allowed": list(key.allowed)} if key.allowed else {}
    minimum = {} if key.minimum is None else {"minimum": key.minimum}
    return {"type": key.type, "default": key.default, **limits, **minimum}


def options_table(streams: StreamOptions) -> Table:
    """A row per stream."""
    table = Table("stream", "runs when", "legal values", show_lines=True)
    for id, options in streams.items():
        when = "\n".join(f"{name}: {str(value).lower()}" for name, value in options["when"].items())
        modes = [
            f"stream {mode['stream']}: {', '.join(mode['resolutions'])}"
            f" at {', '.join(map(str, mode['update_rates']))} Hz, {', '.join(mode['formats'])}"
            for mode in options["modes"]
        ]
        keys = [f"{name}: {_values(key)}" for name, key in options["keys"].items()]
        table.add_row(id, when or "any other runs", "\n".join([*modes, *keys]))
    return table


def _values(key: Mapping[str, Any]) -> str:
    if "allowed" in key:
        return ", ".join(map(str, key["allowed"]))
    if "minimum" in key:
        return f"{key['type']} of at least {key['minimum']:g}"
    return "true, false" if key["type"] == "bool" else str(key["type"])
