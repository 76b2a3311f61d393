"""A headset finds the images that were drawn before it started."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from configurations import only
from counters import have_arrived
from processes import draw_images, receive_once
from simulation import CAMERAS, EYES, STILL, raw_config

_CAMERAS = ("picture_center", "depth_center", *(it for it in CAMERAS if "world" in it), *EYES)
_SMALLEST_MIXED = {"stream": 1, "resolution_width": 648, "resolution_height": 720}
_OPENXR: dict[str, dict[str, Any]] = {it: {"backend": "openxr"} for it in _CAMERAS}


@pytest.mark.parametrize(
    "given",
    [
        raw_config(world_left={"stream": 1}, depth_center={"confidence": True}),
        raw_config(
            **{
                **_OPENXR,
                "picture_center": {**_OPENXR["picture_center"], **_SMALLEST_MIXED},
                "depth_center": {**_OPENXR["depth_center"], "update_rate": 60},
            }
        ),
        only("depth_center: {enabled: true, format: DepthRaw, stream: 0, update_rate: 5}"),
    ],
    ids=["sdk", "openxr", "infra"],
)
def test_a_headset_draws_nothing_after_its_images_were_drawn(given: str, tmp_path: Path) -> None:
    config, cache = tmp_path / "config.yaml", tmp_path / "cache"
    config.write_text(given)
    keys = (f"cache={cache}", "controller_tracked=1")
    options = [*STILL, "--seed", "5", *(word for key in keys for word in ("--simulate", key))]
    draw_images(config, options)
    drawn = {it.name for it in cache.glob("*.frames")}
    receive_once(config, options, tmp_path, is_enough=have_arrived({}, of_others=1))
    assert {it.name for it in cache.glob("*.frames")} == drawn
    assert "frames are rendered" not in (tmp_path / "headset.log").read_text()
