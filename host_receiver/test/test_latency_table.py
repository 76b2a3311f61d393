import importlib.util
from pathlib import Path

import pytest
from rich.console import Console

from command_line import refusal
from ml2_receiver.session.statistics import Latency
from ml2_tools.errors import LatencyError
from ml2_tools.monitoring.latency import Breakdown
from ml2_tools.monitoring.latency_table import Breakdowns, latency_table, write_plot

BREAKDOWNS: Breakdowns = {
    "/x/world_left/image_raw": (
        "world_left",
        Breakdown(90, (1.0, 2.0, 0.25, 0.5), Latency(3.5, 9.0, 0.125)),
    ),
    "/x/world_left/metadata": ("world_left", None),
}
HAS_MATPLOTLIB = importlib.util.find_spec("matplotlib") is not None


def test_a_row_has_the_shares_their_sum_and_the_whole() -> None:
    console = Console(width=200)
    with console.capture() as captured:
        console.print(latency_table(BREAKDOWNS, 3))
    rows = [line.split() for line in captured.get().splitlines() if "world_left" in line]
    figures = ["1.000", "2.000", "0.250", "0.500", "3.750", "3.500", "9.000", "0.125"]
    assert rows == [
        ["world_left/image_raw", "90", *figures],
        ["world_left/metadata", *["-"] * 9],
    ]


@pytest.mark.skipif(not HAS_MATPLOTLIB, reason="matplotlib is not installed")
def test_a_plot_is_a_picture(tmp_path: Path) -> None:
    write_plot(BREAKDOWNS, tmp_path / "latency.png")
    assert (tmp_path / "latency.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.skipif(not HAS_MATPLOTLIB, reason="matplotlib is not installed")
@pytest.mark.parametrize("name", ["missing/latency.png", "latency.nothing"])
def test_a_plot_that_cannot_be_written_is_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(LatencyError, match=f"cannot write .*{name}"):
        write_plot(BREAKDOWNS, tmp_path / name)


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    assert "pip install matplotlib" in refusal("latency", "--plot", "x.png")
