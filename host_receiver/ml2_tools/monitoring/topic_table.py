"""Shows the topics in /diagnostics as a table and as objects for JSON."""

import math
from collections.abc import Mapping
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ml2_receiver.printable import markup
from ml2_receiver.topics.judgement import read_judgements

type Rows = Mapping[str, Mapping[str, str]]

_NUMBERS = {
    "rate_hz": "Hz",
    "expected_hz": "expected\nHz",
    "mbit_per_s": "Mbit/s",
    "received": "received",
    "lost": "lost",
    "latency_p50_ms": "p50\nms",
    "latency_p99_ms": "p99\nms",
    "subscribers": "subscribers",
}
_LARGEST_CELL = 1e15
_UNKNOWN = {"expected_hz": "as delivered"}


def topic_figures(rows: Rows) -> list[dict[str, Any]]:
    """Returns an object per topic.

    `lost` counts all drops, on the host and on the headset. Rates and latencies are those of the
    last second. Unknown values are None, as are those that are no number; without `expected_hz` the
    topic comes as delivered.
    A topic that the stream's configuration leaves out says in `state` what it needs.
    `stream_state` is that of the topic's stream, as `devices` has it; `state` says it in words.
    """
    states = {id: it.state for id, it in read_judgements(rows.get("session", {})).items()}
    return [
        {"topic": name, "type": values["type"], "state": _state(values)}
        | {"stream": (stream := values.get("stream")), "stream_state": states.get(stream or "")}
        | {key: number_of(values.get(key)) for key in _NUMBERS if key != "lost"}
        | {"lost": _lost(values), "dropped": _dropped(values)}
        for name, values in rows.items()
        if "type" in values
    ]


def topic_table(rows: Rows) -> Table:
    """Returns a table with a row per topic."""
    state = rows.get("session", {}).get("message", "")
    table = Table(title=markup(state), title_justify="left", box=SIMPLE_HEAD)
    table.add_column("topic", no_wrap=True)
    for heading in _NUMBERS.values():
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("state")
    for topic in topic_figures(rows):
        cells = (_cell(topic[key], _UNKNOWN.get(key, "-")) for key in _NUMBERS)
        table.add_row(markup(topic["topic"]), *cells, markup(topic["state"]))
    return table


def _state(values: Mapping[str, str]) -> str:
    words, needed = values.get("message", ""), values.get("needs")
    return words if needed is None else f"{words}, needs {needed}"


def _dropped(values: Mapping[str, str]) -> dict[str, int]:
    prefix = "dropped."
    counts = {
        k.removeprefix(prefix): number_of(v) for k, v in values.items() if k.startswith(prefix)
    }
    return {reason: count for reason, count in counts.items() if isinstance(count, int)}


def _lost(values: Mapping[str, str]) -> int | None:
    """Returns the number of lost messages.

    A message that the headset drops is counted as a gap, too, as soon as a later one arrives.
    """
    gaps, unpublished = number_of(values.get("gaps")), number_of(values.get("unpublished"))
    if not isinstance(gaps, int) or not isinstance(unpublished, int):
        return None
    return max(gaps, sum(_dropped(values).values())) + unpublished


def number_of(text: str | None) -> float | int | None:
    """Returns a number of /diagnostics, which anybody may publish; None for what is none."""
    try:
        number = float(text or "")
    except ValueError:
        return None
    if not math.isfinite(number):
        return None
    return int(number) if text is not None and text.isdecimal() else number


def _cell(number: float | int | None, unknown: str) -> str:
    if number is None:
        return unknown
    if abs(number) > _LARGEST_CELL:
        return f"{number:.3g}"
    return str(number) if isinstance(number, int) else f"{number:.1f}"
