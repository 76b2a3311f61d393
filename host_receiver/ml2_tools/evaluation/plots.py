"""Plots two trajectories; the estimate is aligned with the reference."""

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

# The columns are the axes of a camera's body (x forward, y left, z up) in its optical frame.
_BODY = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]])
_DPI = 110


@dataclass(frozen=True)
class PlotData:
    """Both trajectories in the reference's world.

    Attributes:
        stamps_s: the stamps of the estimate's matched poses.
        errors_m: the position error of each matched pose.
    """

    reference: Trajectory
    estimate: Trajectory
    stamps_s: Floats
    errors_m: Floats

    @property
    def start_s(self) -> float:
        return self.reference[0][0] / 1e9

    def error_positions(self) -> Floats:
        """Returns the positions of the estimate's matched poses, n x 3."""
        positions = np.array([pose[:3, 3] for _, pose in self.estimate])
        stamps_s = np.array([stamp_ns / 1e9 for stamp_ns, _ in self.estimate])
        return positions[np.searchsorted(stamps_s, self.stamps_s - 1e-6)]


def plots(data: PlotData) -> dict[str, bytes]:
    """Returns the plots as PNG files, by name."""
    return {name: _png(draw, data) for name, draw in _PLOTS.items()}


def _png(draw: Callable[[Figure, PlotData], None], data: PlotData) -> bytes:
    figure = Figure(figsize=(9, 6), dpi=_DPI, layout="constrained")
    draw(figure, data)
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def _draw_plane(figure: Figure, data: PlotData) -> None:
    axes = figure.add_subplot()
    reference, found = _positions(data.reference), data.error_positions()
    axes.plot(*reference[:, :2].T, color="0.8", linewidth=8, label="headset")
    points = axes.scatter(*found[:, :2].T, **_point_style(data))
    figure.colorbar(points, label="error, cm")
    axes.set(xlabel="x, m", ylabel="y, m", title="From above", aspect="equal")
    axes.legend()


def _draw_space(figure: Figure, data: PlotData) -> None:
    axes = figure.add_subplot(projection="3d")
    reference, found = _positions(data.reference), data.error_positions()
    axes.plot(*reference.T, color="0.8", linewidth=2, label="headset")
    points = axes.scatter(*found.T, **_point_style(data))
    figure.colorbar(points, label="error, cm", shrink=0.7)
    axes.set(xlabel="x, m", ylabel="y, m", zlabel="z, m", title="In space")
    axes.legend()


def _point_style(data: PlotData) -> dict[str, Any]:
    """Returns the style of points that are coloured by error and drawn over the line."""
    style = {"s": 8, "cmap": "viridis", "label": "estimate", "zorder": 3}
    return {"c": data.errors_m * 100, **style}


def _draw_axes(figure: Figure, data: PlotData) -> None:
    _draw_rows(figure, data, _positions, ("x, m", "y, m", "z, m"))


def _draw_angles(figure: Figure, data: PlotData) -> None:
    _draw_rows(figure, data, _angles_deg, ("roll, deg", "pitch, deg", "yaw, deg"))


def _draw_rows(
    figure: Figure, data: PlotData, values: Callable[[Trajectory], Floats], names: tuple[str, ...]
) -> None:
    rows: list[Axes] = list(figure.subplots(len(names), sharex=True))
    for trajectory, label, color, width in (
        (data.reference, "headset", "0.6", 3),
        (data.estimate, "estimate", "tab:blue", 1),
    ):
        seconds = [stamp_ns / 1e9 - data.start_s for stamp_ns, _ in trajectory]
        for axes, name, column in zip(rows, names, values(trajectory).T, strict=True):
            axes.plot(seconds, column, label=label, color=color, linewidth=width)
            axes.set_ylabel(name)
    rows[0].legend()
    rows[-1].set_xlabel("time, s")


def _draw_errors(figure: Figure, data: PlotData) -> None:
    axes = figure.add_subplot()
    axes.plot(data.stamps_s - data.start_s, data.errors_m * 100)
    axes.set(xlabel="time, s", ylabel="error, cm", title="Distance from the reference")


def _positions(trajectory: Trajectory) -> Floats:
    return np.array([pose[:3, 3] for _, pose in trajectory])


def _angles_deg(trajectory: Trajectory) -> Floats:
    """Returns roll, pitch and yaw of the camera's body about fixed x, y and z, n x 3, unwrapped."""
    turns = np.array([pose[:3, :3] for _, pose in trajectory]) @ _BODY
    roll = np.arctan2(turns[:, 2, 1], turns[:, 2, 2])
    pitch = -np.arcsin(np.clip(turns[:, 2, 0], -1, 1))
    yaw = np.arctan2(turns[:, 1, 0], turns[:, 0, 0])
    return np.degrees(np.unwrap(np.stack([roll, pitch, yaw], axis=1), axis=0))


_PLOTS = {
    "plane": _draw_plane,
    "space": _draw_space,
    "axes": _draw_axes,
    "angles": _draw_angles,
    "errors": _draw_errors,
}
