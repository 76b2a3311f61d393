"""Shows latencies as a table and as a plot."""

from collections.abc import Mapping
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ml2_receiver.printable import markup

from ..errors import LatencyError
from .latency import Breakdown

type Breakdowns = Mapping[str, tuple[str, Breakdown | None]]

_SHARES = ("capture → sent", "sent → received", "received → published", "published → subscriber")
_NOTHING = "-"


def latency_table(breakdowns: Breakdowns, duration_s: float) -> Table:
    """Returns a table with a row per topic; topics without messages have dashes."""
    title = f"Latency in ms over the last {duration_s:g} s; stages are means"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD)
    table.add_column("topic", no_wrap=True)
    shares = (share.replace(" → ", "\n→ ") for share in _SHARES)
    for heading in ("messages", *shares, "mean", "p50", "p99", "jitter"):
        table.add_column(heading, justify="right", no_wrap=True)
    for name, (stream, breakdown) in breakdowns.items():
        table.add_row(markup(_short(name, stream)), *_cells(breakdown))
    return table


def _short(name: str, stream: str) -> str:
    """Returns a topic's name without the prefix; it begins with its stream's id, `/` being `_`."""
    return name[max(0, name.replace("/", "_").find(stream)) :]


def _cells(breakdown: Breakdown | None) -> list[str]:
    if breakdown is None:
        return [_NOTHING] * (len(_SHARES) + 5)
    total = breakdown.total
    figures = (*breakdown.shares_ms, sum(breakdown.shares_ms))
    figures += (total.p50_ms, total.p99_ms, total.jitter_ms)
    return [str(breakdown.messages), *(f"{ms:.3f}" for ms in figures)]


def write_plot(breakdowns: Breakdowns, path: Path) -> None:
    """Draws a bar of the stages of each topic, and its p99; needs matplotlib.

    Raises:
        LatencyError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    topics = list(breakdowns.items())[::-1]
    rows = {_short(name, stream): it for name, (stream, it) in topics if it is not None}
    figure = Figure(figsize=(10, 1.5 + 0.3 * len(rows)), layout="constrained")
    axes = figure.subplots()
    names, left_ms = list(rows), [0.0] * len(rows)
    for index, share in enumerate(_SHARES):
        widths_ms = [it.shares_ms[index] for it in rows.values()]
        axes.barh(names, widths_ms, left=left_ms, label=f"{share}, mean")
        left_ms = [left + width for left, width in zip(left_ms, widths_ms, strict=True)]
    axes.plot([it.total.p99_ms for it in rows.values()], names, "k|", label="total, p99")
    axes.margins(y=0.01)
    axes.set_xlabel("ms since the capture")
    axes.legend()
    try:
        figure.savefig(path)
    except (OSError, ValueError) as error:
        raise LatencyError(f"cannot write {path}: {error}") from error
