"""The demo of the README."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import cv2

from processes import PREFIX, ROOT, isolated_environment

DEMO = ROOT / "build" / "demo"


def run_demo(folder: Path, sections: str, *options: str | Path) -> subprocess.CompletedProcess[str]:
    config = folder / "config.yaml"
    config.write_text(f"/ml2_receiver:\n  ros__parameters: {{{sections}}}\n")
    command = [sys.executable, ROOT / "host_receiver" / "demo", "--config", config, *options]
    return subprocess.run(
        [str(word) for word in command],
        check=False,
        capture_output=True,
        text=True,
        env=isolated_environment(),
    )


def test_the_demo_leaves_a_report_and_a_picture(tmp_path: Path) -> None:
    sections = "world_left: {enabled: true}, other_sensors: {enabled: true}"
    demo = run_demo(tmp_path, sections, "--duration", "2")
    assert demo.returncode == 0, demo.stdout + demo.stderr
    report = json.loads((DEMO / "report.json").read_text())
    assert report["source"] == "simulated"
    assert 1 < report["duration_s"] < 4
    assert report["clock"]["uncertainty_s"] > 0
    image = report["topics"][f"{PREFIX}/world_left/image_raw"]
    assert image["type"] == "sensor_msgs/msg/Image"
    assert image["count"] > 5
    assert 0 < image["rate_hz"] < 40
    assert isinstance(image["drops"], int)
    assert 0 < image["latency_ms"]["p50"] <= image["latency_ms"]["p99"]
    assert image["latency_ms"]["p99"] <= image["latency_ms"]["max"]
    assert cv2.imread(str(DEMO / "streams.png")) is not None


def test_a_wrong_configuration_ends_the_demo(tmp_path: Path) -> None:
    demo = run_demo(tmp_path, "world_left: {enabled: maybe}")
    assert demo.returncode == 2
    assert "world_left.enabled" in demo.stdout + demo.stderr


def test_a_demo_without_streams_fails(tmp_path: Path) -> None:
    demo = run_demo(tmp_path, "world_left: {enabled: false}")
    assert demo.returncode == 1
    assert "no stream was accepted" in demo.stdout


def test_a_demo_without_its_recording_fails(tmp_path: Path) -> None:
    demo = run_demo(tmp_path, "world_left: {enabled: true}", "--replay", tmp_path)
    assert demo.returncode == 1
    assert "ended early" in demo.stdout
