"""`ml2-receiver evaluate` on a short recording whose true poses are known."""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from ml2_tools.evaluation.tum import read_tum, write_tum
from ros_processes import environment
from terminal import OnTerminal
from waiting import LIMIT_S
from wall_walk import CAMERA, recording, trajectory

COUNT, LOST = 40, (17,)
PICTURES = ("plane", "space", "axes", "angles", "errors")


def evaluate(*options: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "ml2_receiver", "evaluate", *map(str, options)]
    return subprocess.run(
        command, env=environment(), capture_output=True, text=True, timeout=LIMIT_S, check=False
    )


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recording(tmp_path_factory.mktemp("walk") / "bag", COUNT, LOST)


@pytest.fixture(scope="module")
def folder(bag: Path) -> Path:
    folder, truth = bag.parent / "out", bag.parent / "truth.tum"
    write_tum(truth, trajectory(COUNT))
    run = evaluate("--bag", bag, "--camera", CAMERA, "--truth", truth, "--out", folder)
    assert run.returncode == 0, run.stderr
    assert "error, rmse" in run.stdout
    steps = re.findall(r"^(reading|finding|matching|mapping|placing) ", run.stderr, re.MULTILINE)
    assert steps == ["reading", "finding", "matching", "mapping", "placing"]
    return folder


def test_a_terminal_shows_each_step_with_a_bar(bag: Path, tmp_path: Path) -> None:
    options = ("--bag", str(bag), "--camera", CAMERA, "--out", str(tmp_path / "out"))
    with OnTerminal("evaluate", *options) as child:
        steps = b"reading images.*matching .*mapping key images.*placing images.*error, rmse"
        child.await_shown(b"(?s)" + steps)


@pytest.fixture(scope="module")
def figures(folder: Path) -> dict[str, Any]:
    figures: dict[str, Any] = json.loads((folder / "report.json").read_text())
    return figures


def test_every_image_that_arrived_is_placed_to_a_centimetre(figures: dict[str, Any]) -> None:
    assert figures["images_sent"] == COUNT
    assert figures["matched_pairs"] == figures["images_placed"] == COUNT - len(LOST)
    assert figures["images_rejected"] == 0
    assert figures["rmse_m"] < 0.01
    assert figures["truth"]["rmse_m"] == pytest.approx(figures["rmse_m"], rel=0.05)
    assert figures["headset_against_truth"]["max_m"] < 1e-6
    assert figures["max_dt_s"] < 1e-6
    assert abs(figures["time_offset_s"]) < 1e-3


def test_the_page_needs_no_other_file(folder: Path) -> None:
    page = (folder / "report.html").read_text()
    sources = re.findall(r'(?:src|href)="([^"]{0,40})', page)
    assert len(sources) == len(PICTURES)
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert "error, rmse" in page


def test_markdown_and_its_pictures_are_there(folder: Path) -> None:
    text = (folder / "report.md").read_text()
    for name in PICTURES:
        assert f"({name}.png)" in text
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_the_estimate_is_left_in_the_headsets_world(folder: Path) -> None:
    headset = dict(read_tum(folder / "headset.tum"))
    for stamp_ns, pose in read_tum(folder / "estimate.tum"):
        assert abs(pose - headset[stamp_ns]).max() < 0.03


def test_what_is_no_recording_is_one_line(tmp_path: Path) -> None:
    run = evaluate("--bag", tmp_path / "none", "--camera", CAMERA)
    assert run.returncode == 2
    assert run.stderr.strip() == f"cannot read {tmp_path / 'none'}: No such file or directory"


def test_without_colmap_it_says_what_to_install(bag: Path) -> None:
    script = "import sys; sys.modules['pycolmap'] = None; from ml2_receiver.cli import main; "
    script += f"sys.exit(main(['evaluate', '--bag', {str(bag)!r}, '--camera', {CAMERA!r}]))"
    run = subprocess.run(
        [sys.executable, "-c", script],
        env=environment(),
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert run.returncode == 2
    assert run.stderr.strip() == (
        "structure from motion needs pycolmap: pip install './host_receiver[evaluate]'"
    )
