"""Tells which images the simulated headset shows in a run, so that they are rendered before it.

With an empty cache it leaves captures out, whatever a test asks of rates
(ml2-sensors-aar/simulator/README.md).
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from ml2_receiver.configuration.config import load_config

_CACHE = Path(__file__).resolve().parents[2] / "build/native/frame_cache"
_RANGES = ("depth_long", "depth_short")
# MLDepthCameraFlags
_DEPTH, _CONFIDENCE, _FLAGS, _RAW = 1, 2, 4, 16


def command(config: Path, options: Sequence[str]) -> list[str | Path]:
    """Returns the command that renders the images of a run, which prints "kept" if all are kept.

    Args:
        options: of ml2-headset.
    """
    settings = [f"cache={_CACHE}", *_settings(options)]
    script = Path(__file__).with_name("draw.py")
    return [sys.executable, script, json.dumps(settings), json.dumps(_images(config))]


def note(config: Path, options: Sequence[str]) -> Path | None:
    """Returns the file that exists once a run's images are drawn; None if it simulates none."""
    if "--replay" in options or not (images := _images(config)):
        return None
    settings = _settings(options)
    cache = [_CACHE, *(Path(it[6:]) for it in settings if it.startswith("cache="))][-1]
    text = json.dumps([images, settings], sort_keys=True)
    return cache / f"drawn-{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def forget(config: Path, options: Sequence[str]) -> None:
    """Has the images of a run drawn again before the next one: its cache has lost some."""
    if drawn := note(config, options):
        drawn.unlink(missing_ok=True)


def _settings(options: Sequence[str]) -> list[str]:
    """Returns the keys that decide what the images are, as KEY=VALUE."""
    seeds = [f"seed={value}" for option, value in pairwise(options) if option == "--seed"]
    keys = [value for option, value in pairwise(options) if option == "--simulate"]
    return seeds + [it for it in keys if "=" in it and "fault." not in it and "@" not in it]


def _images(config: Path) -> list[dict[str, Any]]:
    """Returns the images of a configuration, each with the members of ml2sim_images."""
    requests = load_config(config).requests
    cameras = {stream: values for stream, values in requests.items() if "format" in values}
    world = {it for it, values in cameras.items() if values["backend"] == "sdk" and "world" in it}
    # The SDK opens its world cameras with each exposure that one of them has.
    exposures = sorted({cameras[it]["stream"] for it in world})
    return [
        {**_mode(stream, values), "low_exposure": exposure}
        for stream, values in cameras.items()
        for exposure in (exposures if stream in world else [values["stream"]])
    ]


def _mode(stream: str, values: Mapping[str, Any]) -> dict[str, Any]:
    is_depth, is_openxr = stream in ("depth", "infra"), values["backend"] == "openxr"
    rate_hz = values["update_rate"]
    return {
        "camera": _RANGES[values["stream"]] if is_depth else stream,
        "width": values["resolution_width"],
        "height": values["resolution_height"],
        # OpenXR's fastest depth comes at half its rate.
        "rate_hz": 30 if is_depth and is_openxr and rate_hz == 60 else rate_hz,
        "depth_planes": _RAW if stream == "infra" else _planes(values, is_openxr=is_openxr),
    }


def _planes(values: Mapping[str, Any], *, is_openxr: bool) -> int:
    confidence = _CONFIDENCE if is_openxr or values.get("confidence") else 0
    return _DEPTH | _FLAGS | confidence
