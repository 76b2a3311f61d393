"""What the demo says of images that the simulated headset draws while it streams."""

from __future__ import annotations

from pathlib import Path

from left_out import left_out, words


def test_the_newest_count_of_each_camera_is_shown(tmp_path: Path) -> None:
    log = tmp_path / "headset.log"
    log.write_text(
        "connected to desk\n"
        "ml2sim: world camera: 7 captures left out so far, while frames were rendered\n"
        "ml2sim: mixed reality camera: 3 captures left out so far, while frames were rendered\n"
        "ml2sim: world camera: 55 captures left out so far, while frames were rendered\n"
    )
    assert left_out(log) == {"world": 55, "mixed reality": 3}
    shown = words(left_out(log))
    assert shown is not None
    assert shown.endswith(": world 55, mixed reality 3")


def test_nothing_is_said_of_a_headset_that_left_out_nothing(tmp_path: Path) -> None:
    log = tmp_path / "headset.log"
    log.write_text("ml2sim: misuse: world camera: released twice\n")
    assert left_out(log) == {}
    assert words({}) is None
