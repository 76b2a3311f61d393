"""Measures the streams over links of known rate: `make links`. Needs root, for namespaces.

Usage: links.py SECONDS [NAME ...]. A link is a pair of network namespaces whose headset side sends
through a token bucket with a queue of 50 ms; a link with a round trip is delayed_link.py. Writes
build/bench/links.json: everything raw over links of constant rates for SECONDS each and over three
that change, for 40 s each, then compressed streams; and build/bench/long_link.json. With NAMEs it
measures only these, and writes no file.
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from load_run import Loaded, load_run
from processes import PREFIX, ROOT
from shaped_link import QUEUE_S, Link, link, why_not
from simulation import compressed_config, compressed_world_and_depth, one_camera, raw_config

RESULTS = ROOT / "build" / "bench"
FIXED = {"general": {"link": "fixed"}}
RAW = raw_config(**FIXED)
_SINK = """
import socket
server = socket.create_server({})
while True:
    connection, _ = server.accept()
    while connection.recv(1 << 20):
        pass
"""
_SOURCE = """
import socket
connection = socket.create_connection({})
while True:
    connection.sendall(bytes(1 << 16))
"""


def _unchanged(made: Link, over: threading.Event) -> None:
    over.wait()


@dataclass(frozen=True)
class Run:
    """A measurement of `config` over a link.

    `change` may change the link, in a thread, until its event is set.
    """

    name: str
    rate_mbit: float
    congestion: str = "cubic"
    rtt_ms: float = 0.0
    duration_s: float | None = None
    config: str = RAW
    options: tuple[str, ...] = ()
    change: Callable[[Link, threading.Event], None] = _unchanged


def measure(run: Run, duration_s: float) -> dict[str, Any]:
    """Returns the row of a run, of `duration_s` if it has no duration of its own."""
    folder = RESULTS / "links"
    folder.mkdir(parents=True, exist_ok=True)
    config = folder / "config.yaml"
    config.write_text(run.config)
    with link(run.congestion, run.rate_mbit, run.rtt_ms) as made:
        over = threading.Event()
        changing = threading.Thread(target=run.change, args=[made, over])
        changing.start()
        try:
            hosts = (made.receiver, made.headset)
            run_s = run.duration_s or duration_s
            (loaded,) = load_run(config, folder, run_s, headset_options=run.options, hosts=hosts)
        finally:
            over.set()
            changing.join()
        steps = adaptations(folder / "one" / "receiver.log")
        return _row(loaded, run) | {"packets_dropped": made.dropped(), "steps": steps}


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
        "congestion": run.congestion,
        "config": run.name,
        "imu_p50_ms": imu["latency_ms"]["p50"],
        "imu_p99_ms": imu["latency_ms"]["p99"],
        "imu_p99_after_3_s_ms": imu["phases_ms"]["steady"]["p99"],
        "imu_lost": int(imu["diagnostics"].get("produced", imu["count"])) - imu["count"],
        "world_hz": [round(it["rate_hz"], 1) for name, it in images.items() if "/world_" in name],
        "image_hz": {name: round(it["rate_hz"], 1) for name, it in images.items()},
        "world_gaps_ms": [it["gaps_ms"] for name, it in images.items() if "/world_" in name],
        "drops_after_start": loaded.drops_after_start,
        "drops": drops,
        "sent_mbit": sent_bytes * 8e-6 / loaded.duration_s,
    }


def falls_and_rises(made: Link, over: threading.Event) -> None:
    """Changes 100 Mbit/s to 20 Mbit/s and back each 10 s."""
    for rate_mbit in itertools.cycle((20, 100)):
        if over.wait(10):
            return
        made.limit(rate_mbit)


def stalls(made: Link, over: threading.Event) -> None:
    """Stops the link of 100 Mbit/s for a second each 5 s, seven times; its queue stays as long."""
    for _ in range(7):
        if over.wait(4):
            return
        made.limit(0.01, queue_bytes=100e6 / 8 * QUEUE_S)
        over.wait(1)
        made.limit(100)


def competes(made: Link, over: threading.Event) -> None:
    """Sends as much as TCP can beside the headset, from 10 to 20 s of each 20 s."""
    at = (made.receiver.address, 7777)
    sink = [*made.receiver.prefix, sys.executable, "-c", _SINK.format(at)]
    with subprocess.Popen(sink) as taking:
        while not over.wait(10):
            source = [*made.headset.prefix, sys.executable, "-c", _SOURCE.format(at)]
            with subprocess.Popen(source) as sending:
                over.wait(10)
                sending.kill()
        taking.kill()


NOISE = ("image_noise=2", "depth_noise_m=0.001", "depth_noise_per_m=0.003")
NOISY = tuple(word for key in NOISE for word in ("--simulate", key))
LONG = Run("one raw camera", 400, rtt_ms=20, config=one_camera(**FIXED))
AUTO: dict[str, Any] = {"config": compressed_config(), "options": NOISY, "duration_s": 60}
RUNS = (
    *(Run("raw", rate, it) for rate in (300, 100, 50, 30) for it in ("cubic", "bbr")),
    Run("100, 20, 100", 100, duration_s=40, change=falls_and_rises),
    Run("stalls of 1 s", 100, duration_s=40, change=stalls),
    Run("another flow", 100, duration_s=40, change=competes),
    Run("compressed", 300, rtt_ms=10, config=compressed_config(**FIXED), options=NOISY),
    Run(
        *("compressed world and depth", 100),
        config=compressed_world_and_depth(**FIXED),
        options=NOISY,
    ),
    LONG,
    Run("auto", 300, rtt_ms=10, **AUTO),
    *(Run("auto", rate, **AUTO) for rate in (100, 30)),
    Run("auto, 100, 20, 100", 100, change=falls_and_rises, **AUTO),
    Run("auto, another flow", 100, change=competes, **AUTO),
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
