"""Shows the topics in /diagnostics as a table and as objects for JSON."""

import math
from collections.abc import Mapping, Sequence
from posixpath import commonpath, dirname
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table

from ml2_receiver.printable import markup
from ml2_receiver.topics.diagnostics import ALL_ARRIVED, LOST
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
# The columns that a narrow table leaves out, in this order.
_LESS = ("subscribers", "mbit_per_s", "received", "expected_hz")
_LONGEST_NAME, _LEAST_STATE, _ANY_WIDTH = 38, 9, 1000
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


def topic_table(rows: Rows, console: Console) -> Table:
    """Returns a table with a row per topic, as wide as the console.

    A narrow one leaves out the common beginning of the names, and then numbers that matter less.
    """
    figures = topic_figures(rows)
    folders = {dirname(it["topic"]) for it in figures if it["topic"].startswith("/")} - {"/"}
    prefix = f"{commonpath(folders)}/" if folders else ""
    state = rows.get("session", {}).get("message", "")
    narrow = f"{state}; topics under {prefix}" if prefix.strip("/") else state
    table = _table(figures, state, "", tuple(_NUMBERS))
    any_width = console.options.update(max_width=_ANY_WIDTH)
    for count in range(len(_LESS) + 1):
        if Measurement.get(console, any_width, table).minimum <= console.width:
            break
        numbers = tuple(it for it in _NUMBERS if it not in _LESS[:count])
        table = _table(figures, narrow, prefix, numbers)
    return table


def _table(figures: list[dict[str, Any]], title: str, prefix: str, numbers: Sequence[str]) -> Table:
    table = Table(title=markup(title), title_justify="left", box=SIMPLE_HEAD)
    table.add_column("topic", no_wrap=True, max_width=_LONGEST_NAME if prefix else None)
    for key in numbers:
        table.add_column(_NUMBERS[key], justify="right", no_wrap=True)
    table.add_column("state", min_width=_LEAST_STATE)
    for topic in figures:
        cells = (_cell(topic[key], _UNKNOWN.get(key, "-")) for key in numbers)
        words = "✓" if topic["state"] == ALL_ARRIVED else markup(topic["state"])
        if words.startswith(LOST):  # the column says how many
            reasons = ", ".join(reason for reason, count in topic["dropped"].items() if count)
            words = f"lost: {markup(reasons)}" if reasons and not prefix else "lost"
        table.add_row(markup(topic["topic"].removeprefix(prefix)), *cells, words)
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
