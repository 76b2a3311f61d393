"""Writes the report of an evaluation."""

import base64
import html
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ml2_receiver.json_text import json_text

from ..errors import EvaluationError
from .comparison import STATISTICS
from .evaluation import Agreement, Evaluation, summary
from .plots import PlotData, plots
from .trajectory import Trajectory
from .tum import write_tum

_CAPTIONS = {
    "plane": "Where the camera went, from above. The estimate is coloured by its error.",
    "space": "Where the camera went, in 3D.",
    "axes": "Position over time.",
    "angles": "Orientation of the camera's body (x forward, y left, z up) over time.",
    "errors": "Error over time.",
}
_EXPLANATION = """\
The estimator used only the images and the camera's lens. Its trajectory was aligned with the
reference by scale, rotation and translation (Sim(3), Umeyama); the errors are those after the
alignment. The time offset is the time to add to the images' stamps for the least error. A shift
that images and poses have in common shows only in the comparison with the truth."""
_HEADINGS = ("estimate and headset", "estimate and truth", "headset and truth")
_STYLE = """\
body { font: 16px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem }
table { border-collapse: collapse } td, th { padding: .2rem 1rem .2rem 0; text-align: left }
td + td, th + th { text-align: right } figure { margin: 2rem 0 } img { max-width: 100% }"""


def write_report(folder: Path, evaluation: Evaluation) -> None:
    """Writes report.json, report.md, report.html (one file with its plots), PNG and TUM files.

    Replaces the files of an earlier evaluation.

    Raises:
        EvaluationError: `folder` cannot be written to.
    """
    drawn = plots(_plot_data(evaluation))
    figures = summary(evaluation)
    rows = list(table(figures))
    title = f"{figures['recording']}: {evaluation.camera} by {evaluation.estimator}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "report.json").write_text(json_text(figures, indent=2) + "\n", "utf-8")
        (folder / "report.md").write_text(_markdown(title, rows, drawn), "utf-8")
        (folder / "report.html").write_text(_page(title, rows, drawn), "utf-8")
        for name, picture in drawn.items():
            (folder / f"{name}.png").write_bytes(picture)
        write_tum(folder / "headset.tum", evaluation.headset.reference)
        write_tum(folder / "estimate.tum", _aligned(evaluation.estimate, evaluation.headset))
    except OSError as error:
        raise EvaluationError(f"cannot write to {folder}: {error.strerror}") from error


def table(figures: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Yields a heading, then rows; with two more columns if the truth is known."""
    with_truth = [figures[key] for key in ("truth", "headset_against_truth") if figures[key]]
    yield ("", *_HEADINGS[: 1 + len(with_truth)])
    blank = [""] * len(with_truth)
    yield "duration", f"{figures['duration_s']:.1f} s", *blank
    for state in ("sent", "received", "placed", "rejected"):
        if (count := figures[f"images_{state}"]) is not None:
            yield f"images {state}", f"{count}", *blank
    for name, cell in _ROWS.items():
        yield name, *(cell(column) for column in (figures, *with_truth))


def _error(name: str, figures: Mapping[str, Any]) -> str:
    return f"{figures[f'{name}_m'] * 100:.2f} cm"


def _relative(key: str, factor: float, unit: str, figures: Mapping[str, Any]) -> str:
    value = figures[key].get("rmse")
    return "path too short" if value is None else f"{value * factor:.2f} {unit}"


def _offset(figures: Mapping[str, Any]) -> str:
    value = figures["time_offset_s"]
    return "unknown" if value is None else f"{value * 1000:.2f} ms"


_ROWS: dict[str, Callable[[Mapping[str, Any]], str]] = {
    "path": lambda it: f"{it['path_m']:.2f} m",
    "matched pairs": lambda it: f"{it['matched_pairs']}",
    "longest time in a pair": lambda it: f"{it['max_dt_s'] * 1000:.3f} ms",
    **{f"error, {name}": partial(_error, name) for name in STATISTICS},
    "error per metre, rmse": partial(_relative, "rpe_m_per_m", 100, "cm"),
    "rotation error per metre, rmse": partial(_relative, "rpe_deg_per_m", 1, "deg"),
    "time offset": _offset,
}


def _aligned(estimate: Trajectory, agreement: Agreement) -> Trajectory:
    """Returns the estimate in the reference's world; the scale is taken out of the rotations."""
    alignment = agreement.comparison.alignment
    scale = np.cbrt(np.linalg.det(alignment[:3, :3]))
    moved = []
    for stamp_ns, pose in estimate:
        placed = alignment @ pose
        placed[:3, :3] /= scale
        moved.append((stamp_ns, placed))
    return moved


def _plot_data(evaluation: Evaluation) -> PlotData:
    first_ns, last_ns = evaluation.estimate[0][0], evaluation.estimate[-1][0]
    headset = evaluation.headset
    reference = [(at, pose) for at, pose in headset.reference if first_ns <= at <= last_ns]
    estimate = _aligned(evaluation.estimate, headset)
    return PlotData(reference, estimate, headset.comparison.stamps_s, headset.comparison.errors_m)


def _markdown(title: str, rows: list[tuple[str, ...]], drawn: Mapping[str, bytes]) -> str:
    lines = [f"# {title}", "", _EXPLANATION, "", *_markdown_table(rows), ""]
    for name in drawn:
        lines += [f"![{_CAPTIONS[name]}]({name}.png)", ""]
    return "\n".join(lines)


def _markdown_table(rows: list[tuple[str, ...]]) -> Iterator[str]:
    heading, *rest = (f"| {' | '.join(row)} |" for row in rows)
    yield heading
    yield "|---" * len(rows[0]) + "|"
    yield from rest


def _page(title: str, rows: list[tuple[str, ...]], drawn: Mapping[str, bytes]) -> str:
    cells = ("<tr>" + "".join(f"<td>{html.escape(it)}</td>" for it in row) for row in rows)
    figures = (
        f'<figure><img alt="" src="data:image/png;base64,{base64.b64encode(picture).decode()}">'
        f"<figcaption>{_CAPTIONS[name]}</figcaption></figure>"
        for name, picture in drawn.items()
    )
    return "\n".join(
        [
            f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}',
            f"</title><style>{_STYLE}</style><h1>{html.escape(title)}</h1>",
            f"<p>{html.escape(_EXPLANATION)}</p>",
            "<table>",
            *cells,
            "</table>",
            *figures,
            "</html>\n",
        ]
    )
