"""Shows checks as a table with a row per topic, and the problems as sentences."""

from collections.abc import Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ml2_receiver.printable import markup

from .check import VERDICTS, Check, Verdict

_COLOURS = {"ok": "green", "hint": "yellow", "wrong": "red"}
_BARS = " ▁▂▃▄▅▆▇█"
_COLUMNS = {
    "messages": ("messages", "messages"),
    "rate": ("Hz", "rate_hz"),
    "gaps": ("missing", "missing"),
    "jitter": ("jitter\np99 ms", "p99_ms"),
    "latency": ("latency\np99 ms", "p99_ms"),
    "stamps": ("stamps", ""),
    "pairs with camera_info": ("camera\ninfo", "pairs"),
    "pairs with metadata": ("metadata", "pairs"),
    "transforms": ("at\n/tf", "exact"),
}


def integrity_table(checks: Sequence[Check]) -> Table:
    """Returns a table of figures in the colour of their verdict, with a histogram of the jitter."""
    table = Table(box=SIMPLE_HEAD)
    table.add_column("topic", no_wrap=True)
    for heading, _ in _COLUMNS.values():
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("intervals\n-½ to +½ period", no_wrap=True)
    rows: dict[str, dict[str, Check]] = {}
    for check in checks:
        rows.setdefault(check.topic, {})[check.check] = check
    for topic, row in rows.items():
        if "messages" in row:
            cells = (_cell(row.get(check), key) for check, (_, key) in _COLUMNS.items())
            table.add_row(markup(topic), *cells, _histogram(row.get("jitter")))
    return table


def problems(checks: Sequence[Check]) -> list[str]:
    """Returns a line of markup per problem; topics with the same problem share a line.

    The worst problems come first.
    """
    bad: dict[tuple[Verdict, str, str], list[str]] = {}
    for it in checks:
        if it.verdict != "ok":
            bad.setdefault((it.verdict, it.check, it.found), []).append(it.topic)
    return [
        f"[{_COLOURS[verdict]}]{verdict}[/] {markup(_sentence(topics, check, found))}"
        for (verdict, check, found), topics in sorted(
            bad.items(), key=lambda item: -VERDICTS.index(item[0][0])
        )
    ]


def _sentence(topics: Sequence[str], check: str, found: str) -> str:
    if len(topics) == 1:
        return f"{topics[0]}: {check}: {found}"
    return f"{check} of {len(topics)} topics: {found} ({', '.join(topics)})"


def _cell(check: Check | None, key: str) -> str:
    if check is None:
        return "-"
    return f"[{_COLOURS[check.verdict]}]{_figure(check, key)}[/]"


def _figure(check: Check, key: str) -> str:
    value = check.figures.get(key, check.verdict)
    return f"{value:.2f}" if isinstance(value, float) else str(value)


def _histogram(check: Check | None) -> str:
    """Draws a bar per bin; every bin that is not empty has a visible bar."""
    counts = _counts(check.figures) if check is not None else []
    most = max(counts, default=0)
    return "".join(_BARS[-(-count * (len(_BARS) - 1) // most)] if most else " " for count in counts)


def _counts(figures: Mapping[str, object]) -> list[int]:
    counts = figures.get("histogram_counts")
    return counts if isinstance(counts, list) else []
