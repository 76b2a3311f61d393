"""Writes the validation's figures and the thesis's as Markdown tables."""

from collections.abc import Iterable
from typing import Any

from walks import THESIS_RMSE_M


def _heading(*names: str) -> str:
    return f"| {' | '.join(names)} |\n{'|---' * len(names)}|"


_WALKS = _heading(
    *("trajectory", "path", "images sent", "matched", "rmse", "mean", "max"),
    *("rmse to the truth", "time offset to it", "thesis's rmse"),
)
_OTHERS = _heading(
    *("trajectory", "images sent", "matched", "rmse", "max", "rmse per metre", "time offset"),
    *("rmse to the truth", "time offset to it"),
)


def page(entries: Iterable[dict[str, Any]]) -> str:
    """Returns the tables; lengths are in cm, offsets in ms."""
    entries = list(entries)
    walks, others = entries[: len(THESIS_RMSE_M)], entries[len(THESIS_RMSE_M) :]
    lines = [_WALKS, *map(_walk, walks, THESIS_RMSE_M), "", _OTHERS, *map(_other, others)]
    return "\n".join(lines) + "\n"


def _walk(it: dict[str, Any], thesis_rmse_m: float) -> str:
    truth = it["truth"]
    cells = [
        it["trajectory"],
        f"{it['path_m']:.1f} m",
        str(it["images_sent"]),
        str(it["matched_pairs"]),
        *(_cm(it[key]) for key in ("rmse_m", "mean_m", "max_m")),
        _cm(truth["rmse_m"]),
        _ms(truth["time_offset_s"]),
        f"{thesis_rmse_m * 100:.1f} cm",
    ]
    return f"| {' | '.join(cells)} |"


def _other(it: dict[str, Any]) -> str:
    truth = it["truth"] or {}
    cells = [
        ", ".join(filter(None, (it["trajectory"], it.get("fault")))),
        str(it["images_sent"]),
        str(it["matched_pairs"]),
        *(_cm(it[key]) for key in ("rmse_m", "max_m")),
        _cm(it["rpe_m_per_m"].get("rmse")),
        _ms(it["time_offset_s"]),
        _cm(truth.get("rmse_m")),
        _ms(truth.get("time_offset_s")),
    ]
    return f"| {' | '.join(cells)} |"


def _cm(length_m: float | None) -> str:
    return "" if length_m is None else f"{length_m * 100:.2f} cm"


def _ms(time_s: float | None) -> str:
    return "" if time_s is None else f"{time_s * 1000:.2f} ms"
