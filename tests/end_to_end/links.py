"""Measures the streams over links of known rate: `make links`. Needs root, for namespaces.

Usage: links.py SECONDS [NAME ...]. A link is a pair of network namespaces whose headset side sends
through a token bucket with a queue of 50 ms. Where the app wants 20 MB/s of ROS, the receiver side
does so, too, through its own bucket or the same one. A link with a round trip is delayed_link.py.
Writes build/bench/links.json: everything raw over links of constant rates for SECONDS each and over
three that change, for 40 s each, then compressed streams and video; and build/bench/long_link.json.
With NAMEs it measures only these, and writes no file.
"""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

import drawing
from left_out import left_out
from link_changes import Change, competes, falls_and_rises, followed, nothing, stalls
from load_run import Loaded, load_run
from processes import PREFIX, ROOT, draw_images, isolated_environment
from shaped_link import Link, link, why_not
from simulation import (
    compressed_config,
    compressed_world_and_depth,
    one_camera,
    raw_config,
    video_config,
)

RESULTS = ROOT / "build" / "bench"
FIXED = {"general": {"link": "fixed"}}
RAW = raw_config(**FIXED)


@dataclass(frozen=True)
class Run:
    """A measurement of `config` over a link.

    `change` may change the link, in a thread, until its event is set; it notes what it changed.
    `is_much_wanted` says that the app wants 20 MB/s of ROS.
    """

    name: str
    rate_mbit: float
    congestion: str = "cubic"
    rtt_ms: float = 0.0
    way_back: Literal["free", "own", "shared"] = "free"
    duration_s: float | None = None
    config: str = RAW
    options: tuple[str, ...] = ()
    change: Callable[[Link, threading.Event, list[Change]], None] = nothing
    is_much_wanted: bool = False


@contextmanager
def wanted(run: Run, made: Link, environment: dict[str, str]) -> Iterator[None]:
    """Publishes 20 MB/s for the app, if the run is one of that."""
    if not run.is_much_wanted:
        yield
        return
    role = (ROOT / "tests" / "bench" / "roles.py", "publisher", LARGE_TOPIC, "20", str(LARGE_BYTES))
    command = (*made.receiver.prefix, sys.executable, *role)
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, text=True, env=environment) as publisher:
        assert publisher.stdin is not None
        print(10**6, file=publisher.stdin, flush=True)
        try:
            yield
        finally:
            publisher.kill()


def measure(run: Run, duration_s: float) -> dict[str, Any]:
    """Returns the row of a run, of `duration_s` if it has no duration of its own.

    Draws the images first, which takes processors and lowers rates, and measures again if the
    cache has lost them.
    """
    folder = RESULTS / "links"
    folder.mkdir(parents=True, exist_ok=True)
    config = folder / "config.yaml"
    config.write_text(run.config)
    draw_images(config, run.options)
    row = _measured(run, config, folder, duration_s)
    if left_out(folder / "one" / "headset.log"):
        drawing.forget(config, run.options)
        draw_images(config, run.options)
        row = _measured(run, config, folder, duration_s)
    return row


def _measured(run: Run, config: Path, folder: Path, duration_s: float) -> dict[str, Any]:
    environment = isolated_environment()
    with (
        link(run.congestion, run.rate_mbit, run.rtt_ms, run.way_back) as made,
        wanted(run, made, environment),
    ):
        over = threading.Event()
        changes: list[Change] = []
        changing = threading.Thread(target=run.change, args=[made, over, changes])
        changing.start()
        try:
            hosts = (made.receiver, made.headset)
            run_s = run.duration_s or duration_s
            options = (*run.options, *(SUBSCRIBE if run.is_much_wanted else ()))
            more: dict[str, Any] = {"headset_options": options, "environment": environment}
            (loaded,) = load_run(config, folder, run_s, hosts=hosts, **more)
        finally:
            over.set()
            changing.join()
        steps = adaptations(folder / "one" / "receiver.log")
        row = _row(loaded, run) | {"packets_dropped": made.dropped(), "steps": steps}
        if run.is_much_wanted:
            arrived = (folder / "one" / "headset.log").read_text().count(f"\n{LARGE_TOPIC} ")
            row["down_mbit"] = arrived * LARGE_BYTES * 8e-6 / loaded.duration_s
        if changes:
            row["changes"] = _changes(changes, folder / "one" / "arrivals.npz")
        return row


def _changes(changes: list[Change], arrivals: Path) -> list[dict[str, Any]]:
    """Returns how the streams followed each change, from what the subscriber wrote."""
    with np.load(arrivals) as topics:
        messages = np.concatenate([topics[name][:, [0, 2]] for name in topics])
        imu = topics[f"{PREFIX}/imu_left/imu"][:, :2]
    return followed(changes, imu, messages[messages[:, 0].argsort()])


def adaptations(log: Path) -> list[str]:
    """Returns what a receiver's log says of images that gave way to the link."""
    return [line.strip() for line in log.read_text().splitlines() if "images" in line]


def _row(loaded: Loaded, run: Run) -> dict[str, Any]:
    topics = loaded.final["topics"]
    imu = topics[f"{PREFIX}/imu_left/imu"]
    images = {name: it for name, it in topics.items() if "/image_raw" in name and it["count"]}
    drops: dict[str, int] = {}
    for seen in topics.values():
        for key, count in seen["diagnostics"].items():
            if key.startswith("dropped."):
                drops[key[8:]] = drops.get(key[8:], 0) + int(count)
    sent_bytes = sum(seen["bytes"] for seen in topics.values())
    return {
        "link_mbit": run.rate_mbit,
        "rtt_ms": run.rtt_ms,
        "way_back": run.way_back,
        "congestion": run.congestion,
        "config": run.name,
        "imu_p50_ms": imu["latency_ms"]["p50"],
        "imu_p99_ms": imu["latency_ms"]["p99"],
        "imu_p99_after_3_s_ms": imu["phases_ms"]["steady"]["p99"],
        "imu_late": int(imu["diagnostics"].get("dropped.source_late", 0)),
        "imu_lost": int(imu["diagnostics"].get("produced", imu["count"])) - imu["count"],
        "world_hz": [round(it["rate_hz"], 1) for name, it in images.items() if "/world_" in name],
        "image_hz": {name: round(it["rate_hz"], 1) for name, it in images.items()},
        "world_gaps_ms": [it["gaps_ms"] for name, it in images.items() if "/world_" in name],
        "drops_after_start": loaded.drops_after_start,
        "drops": drops,
        "sent_mbit": sent_bytes * 8e-6 / loaded.duration_s,
    }


LARGE_TOPIC, LARGE_BYTES = "/bench/large", 1_000_000
SUBSCRIBE = ("--subscribe", LARGE_TOPIC, "std_msgs/msg/UInt8MultiArray")
NOISE = ("noise=0", "image_noise=2", "depth_noise_m=0.001", "depth_noise_per_m=0.003")
NOISY = tuple(word for key in NOISE for word in ("--simulate", key))
LONG = Run("one raw camera", 400, rtt_ms=20, config=one_camera(**FIXED))
WAYS: tuple[Literal["own", "shared"], ...] = ("own", "shared")
AUTO: dict[str, Any] = {"config": compressed_config(), "options": NOISY, "duration_s": 60}
MUCH: dict[str, Any] = {
    "config": compressed_config() + f"    app: {{subscribe: [{LARGE_TOPIC}]}}\n",
    "options": NOISY,
    "duration_s": 60,
}
PUBLISHED: dict[str, Any] = {
    "config": compressed_config(custom={"enabled": True}),
    "options": (*NOISY, "--publish", "large", "4000000", "5", "0"),
    "duration_s": 60,
}
RUNS = (
    *(Run("raw", rate, it) for rate in (300, 100, 50, 30) for it in ("cubic", "bbr")),
    *(Run("raw", rate, rtt_ms=rtt) for rate in (180, 70, 45) for rtt in (0, 20, 60)),
    Run("100, 20, 100", 100, duration_s=40, change=falls_and_rises),
    Run("stalls of 1 s", 100, duration_s=40, change=stalls),
    Run("another flow", 100, duration_s=40, change=competes),
    Run("compressed", 300, rtt_ms=10, config=compressed_config(**FIXED), options=NOISY),
    Run(
        *("compressed world and depth", 100),
        config=compressed_world_and_depth(**FIXED),
        options=NOISY,
    ),
    Run("h264", 100, config=video_config(**FIXED), options=NOISY),
    LONG,
    Run("auto", 300, rtt_ms=10, **AUTO),
    *(Run("auto", rate, **AUTO) for rate in (100, 45, 30)),
    Run("auto", 70, rtt_ms=60, **AUTO),
    Run("auto, 100, 20, 100", 100, change=falls_and_rises, **AUTO),
    Run("auto, another flow", 100, change=competes, **AUTO),
    Run("auto, 4 MB published at 5 Hz", 100, **PUBLISHED),
    *(Run("auto, nothing wanted", rate, **MUCH) for rate in (100, 30)),
    *(
        Run(f"auto, 20 MB/s wanted, {way}", rate, way_back=way, is_much_wanted=True, **MUCH)
        for rate in (100, 30)
        for way in WAYS
    ),
)


def main(duration_s: float, names: list[str]) -> None:
    if reason := why_not():
        raise SystemExit(f"{reason}: run make links as root on a machine with tc")
    rows: list[dict[str, Any]] = []
    began_s = time.monotonic()
    for run in RUNS:
        if not names or run.name in names:
            rows.append(measure(run, duration_s))
            print(f"{time.monotonic() - began_s:4.0f} s", json.dumps(rows[-1]), flush=True)
    if names:
        return
    (RESULTS / "links.json").write_text(json.dumps(rows, indent=2) + "\n")
    long = next(row for row in rows if row["config"] == LONG.name)
    figures = {"raw_camera_hz": long["world_hz"][0], "imu_p99_ms": long["imu_p99_ms"]}
    (RESULTS / "long_link.json").write_text(json.dumps(long | figures, indent=2) + "\n")


if __name__ == "__main__":
    main(float(sys.argv[1]), sys.argv[2:])
