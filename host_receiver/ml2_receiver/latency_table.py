"""Latencies for people: a table, and a picture."""

from collections.abc import Mapping
from pathlib import Path

from rich.table import Table

from .errors import LatencyError
from .latency import Breakdown

type Breakdowns = Mapping[str, tuple[str, Breakdown | None]]

_SHARES = ("capture → sent", "sent → received", "received → published", "published → subscriber")
_NOTHING = "-"


def latency_table(breakdowns: Breakdowns, duration_s: float) -> Table:
    """A row per topic; topics of which nothing came have dashes."""
    table = Table(title=f"Milliseconds, of the last {duration_s:g} s; shares are means")
    for heading in ("stream", "topic"):
        table.add_column(heading, no_wrap=True)
    shares = (share.replace(" → ", "\n→ ") for share in _SHARES)
    for heading in ("messages", *shares, "mean", "p50", "p99", "jitter"):
        table.add_column(heading, justify="right")
    previous_stream = ""
    for name, (stream, breakdown) in breakdowns.items():
        shown_stream = stream if stream != previous_stream else ""
        table.add_row(shown_stream, name, *_cells(breakdown))
        previous_stream = stream
    return table


def _cells(breakdown: Breakdown | None) -> list[str]:
    if breakdown is None:
        return [_NOTHING] * (len(_SHARES) + 5)
    total = breakdown.total
    figures = (*breakdown.shares_ms, sum(breakdown.shares_ms))
    figures += (total.p50_ms, total.p99_ms, total.jitter_ms)
    return [str(breakdown.messages), *(f"{ms:.3f}" for ms in figures)]


def write_plot(breakdowns: Breakdowns, path: Path) -> None:
    """A bar of shares per topic, and its p99; needs matplotlib.

    Raises:
        LatencyError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    rows = {name: it for name, (_, it) in list(breakdowns.items())[::-1] if it is not None}
    figure = Figure(figsize=(10, 1.5 + 0.3 * len(rows)), layout="constrained")
    axes = figure.subplots()
    names, left_ms = list(rows), [0.0] * len(rows)
    for index, share in enumerate(_SHARES):
        widths_ms = [it.shares_ms[index] for it in rows.values()]
        axes.barh(names, widths_ms, left=left_ms, label=f"{share}, mean")
        left_ms = [left + width for left, width in zip(left_ms, widths_ms, strict=True)]
    axes.plot([it.total.p99_ms for it in rows.values()], names, "k|", label="total, p99")
    axes.set_xlabel("ms since the capture")
    axes.legend()
    try:
        figure.savefig(path)
    except (OSError, ValueError) as error:
        raise LatencyError(f"cannot write {path}: {error}") from error
