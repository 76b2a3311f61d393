"""The demo as the README has it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import cv2

from processes import PREFIX, ROOT, isolated_environment

DEMO = ROOT / "build" / "demo"


def run_demo(config: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, ROOT / "host_receiver" / "demo", "--duration", "2"]
    return subprocess.run(
        [*map(str, command), "--config", str(config)],
        check=False,
        capture_output=True,
        text=True,
        env=isolated_environment(),
    )


def test_the_demo_leaves_a_report_and_a_picture(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(
        "/ml2_receiver:\n  ros__parameters:\n"
        "    world_left: {enabled: true}\n    other_sensors: {enabled: true}\n"
    )
    demo = run_demo(config)
    assert demo.returncode == 0, demo.stdout + demo.stderr
    report = json.loads((DEMO / "report.json").read_text())
    assert report["source"] == "simulated"
    assert 1 < report["duration_s"] < 4
    assert report["clock"]["uncertainty_s"] > 0
    image = report["topics"][f"{PREFIX}/world_left/image_raw"]
    assert image["type"] == "sensor_msgs/msg/Image"
    assert image["count"] > 20
    assert 20 < image["rate_hz"] < 40
    assert isinstance(image["drops"], int)
    assert 0 < image["latency_ms"]["p50"] <= image["latency_ms"]["p99"]
    assert image["latency_ms"]["p99"] <= image["latency_ms"]["max"]
    assert cv2.imread(str(DEMO / "streams.png")) is not None


def test_a_demo_without_streams_fails(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text("/ml2_receiver:\n  ros__parameters:\n    world_left: {enabled: maybe}\n")
    demo = run_demo(config)
    assert demo.returncode == 2
    assert "world_left.enabled" in demo.stdout + demo.stderr
