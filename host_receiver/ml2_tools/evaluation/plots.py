"""Pictures of two trajectories, the estimate aligned with the reference."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from .trajectory import Trajectory

type Floats = NDArray[np.float64]

# Columns are the axes of a camera's body (x forward, y left, z up) in those of its optical frame.
_BODY = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]])
_DPI = 110


@dataclass(frozen=True)
class Pictured:
    """Both trajectories in the reference's world.

    Attributes:
        errors_m: of each matched pose of the estimate, at `stamps_s`.
    """

    reference: Trajectory
    estimate: Trajectory
    stamps_s: Floats
    errors_m: Floats

    @property
    def start_s(self) -> float:
        return self.reference[0][0] / 1e9

    def error_positions(self) -> Floats:
        """Positions of the estimate's matched poses."""
        positions = np.array([pose[:3, 3] for _, pose in self.estimate])
        stamps_s = np.array([stamp_ns / 1e9 for stamp_ns, _ in self.estimate])
        return positions[np.searchsorted(stamps_s, self.stamps_s - 1e-6)]


def pictures(pictured: Pictured) -> dict[str, bytes]:
    """PNG files by what they show."""
    return {name: _png(draw, pictured) for name, draw in _PICTURES.items()}


def _png(draw: Callable[[Figure, Pictured], None], pictured: Pictured) -> bytes:
    figure = Figure(figsize=(9, 6), dpi=_DPI, layout="constrained")
    draw(figure, pictured)
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def _draw_plane(figure: Figure, it: Pictured) -> None:
    axes = figure.add_subplot()
    reference, found = _positions(it.reference), it.error_positions()
    axes.plot(*reference[:, :2].T, color="0.8", linewidth=8, label="headset")
    points = axes.scatter(*found[:, :2].T, **_coloured(it))
    figure.colorbar(points, label="error, cm")
    axes.set(xlabel="x, m", ylabel="y, m", title="From above", aspect="equal")
    axes.legend()


def _draw_space(figure: Figure, it: Pictured) -> None:
    axes = figure.add_subplot(projection="3d")
    reference, found = _positions(it.reference), it.error_positions()
    axes.plot(*reference.T, color="0.8", linewidth=2, label="headset")
    points = axes.scatter(*found.T, **_coloured(it))
    figure.colorbar(points, label="error, cm", shrink=0.7)
    axes.set(xlabel="x, m", ylabel="y, m", zlabel="z, m", title="In space")
    axes.legend()


def _coloured(it: Pictured) -> dict[str, Any]:
    """By error, and before the line."""
    style = {"s": 8, "cmap": "viridis", "label": "estimate", "zorder": 3}
    return {"c": it.errors_m * 100, **style}


def _draw_axes(figure: Figure, it: Pictured) -> None:
    _draw_rows(figure, it, _positions, ("x, m", "y, m", "z, m"))


def _draw_angles(figure: Figure, it: Pictured) -> None:
    _draw_rows(figure, it, _angles_deg, ("roll, deg", "pitch, deg", "yaw, deg"))


def _draw_rows(
    figure: Figure, it: Pictured, values: Callable[[Trajectory], Floats], names: tuple[str, ...]
) -> None:
    rows: list[Axes] = list(figure.subplots(len(names), sharex=True))
    for trajectory, label, color, width in (
        (it.reference, "headset", "0.6", 3),
        (it.estimate, "estimate", "tab:blue", 1),
    ):
        seconds = [stamp_ns / 1e9 - it.start_s for stamp_ns, _ in trajectory]
        for axes, name, column in zip(rows, names, values(trajectory).T, strict=True):
            axes.plot(seconds, column, label=label, color=color, linewidth=width)
            axes.set_ylabel(name)
    rows[0].legend()
    rows[-1].set_xlabel("time, s")


def _draw_errors(figure: Figure, it: Pictured) -> None:
    axes = figure.add_subplot()
    axes.plot(it.stamps_s - it.start_s, it.errors_m * 100)
    axes.set(xlabel="time, s", ylabel="error, cm", title="Distance from the reference")


def _positions(trajectory: Trajectory) -> Floats:
    return np.array([pose[:3, 3] for _, pose in trajectory])


def _angles_deg(trajectory: Trajectory) -> Floats:
    """Roll, pitch and yaw of the camera's body about fixed x, y and z; without jumps."""
    turns = np.array([pose[:3, :3] for _, pose in trajectory]) @ _BODY
    roll = np.arctan2(turns[:, 2, 1], turns[:, 2, 2])
    pitch = -np.arcsin(np.clip(turns[:, 2, 0], -1, 1))
    yaw = np.arctan2(turns[:, 1, 0], turns[:, 0, 0])
    return np.degrees(np.unwrap(np.stack([roll, pitch, yaw], axis=1), axis=0))


_PICTURES = {
    "plane": _draw_plane,
    "space": _draw_space,
    "axes": _draw_axes,
    "angles": _draw_angles,
    "errors": _draw_errors,
}
