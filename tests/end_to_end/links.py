"""Measures everything raw over links of known rate: `make links`. Needs root, for namespaces.

Usage: links.py SECONDS. A link is a pair of network namespaces whose headset side sends through a
token bucket with a queue of 50 ms. Writes build/bench/links.json: links of constant rates for
SECONDS each, and three that change, for 40 s each.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from load_run import Host, Loaded, load_run
from processes import PREFIX, ROOT

RESULTS = ROOT / "build" / "bench"
CONFIG = ROOT / "config" / "demo.yaml"
WORLD = ("world_left", "world_center", "world_right")
_QUEUE_S = 0.05
_BURST_BYTES = 32 * 1024
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


@dataclass(frozen=True)
class Link:
    """Two namespaces, and the token bucket between them."""

    receiver: Host
    headset: Host
    device: str

    def limit(self, rate_mbit: float, queue_bytes: float | None = None) -> None:
        """Sets the rate of what the headset sends; it can be changed at any time.

        Args:
            queue_bytes: what waits in the link at most; None means what it sends in 50 ms.
        """
        queue_bytes = queue_bytes or rate_mbit * 1e6 / 8 * _QUEUE_S
        _run(
            *(*self.headset.prefix, "tc", "qdisc", "replace", "dev", self.device, "root", "tbf"),
            *("rate", f"{rate_mbit}mbit", "burst", str(_BURST_BYTES)),
            *("limit", str(int(queue_bytes) + _BURST_BYTES)),
        )

    def dropped(self) -> int:
        """Returns how many packets the queue has dropped."""
        show = ("tc", "-j", "-s", "qdisc", "show", "dev", self.device)
        (root, *_) = json.loads(_run(*self.headset.prefix, *show))
        return int(root["drops"])


@contextlib.contextmanager
def link(congestion: str) -> Iterator[Link]:
    """Makes a link whose TCP connections use this congestion control."""
    near, far = f"ml2r{os.getpid()}", f"ml2h{os.getpid()}"
    with contextlib.ExitStack() as stack:
        for name in (near, far):
            _run("ip", "netns", "add", name)
            stack.callback(_run, "ip", "netns", "delete", name)
            _run("ip", "-n", name, "link", "set", "lo", "up")
        _run("ip", "link", "add", far, "netns", far, "type", "veth", "peer", near)
        _run("ip", "link", "set", near, "netns", near)
        for name, address in ((near, "10.77.0.1"), (far, "10.77.0.2")):
            _run("ip", "-n", name, "address", "add", f"{address}/30", "dev", name)
            _run("ip", "-n", name, "link", "set", name, "up")
            route = ("10.77.0.0/30", "dev", name, "src", address, "congctl", congestion)
            _run("ip", "-n", name, "route", "replace", *route)
        execute = ("ip", "netns", "exec")
        yield Link(Host((*execute, near), "10.77.0.1"), Host((*execute, far), "10.77.0.2"), far)


def _run(*command: str | Path) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def why_not() -> str | None:
    """Returns why this machine can make no links, or None if it can."""
    if os.geteuid() != 0:
        return "only root may make network namespaces"
    try:
        with link("cubic") as made:
            made.limit(100)
    except (OSError, subprocess.CalledProcessError) as error:
        return f"this machine makes no links: {error}"
    return None


def measure(
    rate_mbit: float,
    congestion: str,
    duration_s: float,
    change: Callable[[Link, threading.Event], None] = lambda *_: None,
) -> dict[str, Any]:
    """Sends everything raw over a link; `change` may change it in a thread until its event."""
    with link(congestion) as made:
        made.limit(rate_mbit)
        over = threading.Event()
        changing = threading.Thread(target=change, args=[made, over])
        changing.start()
        try:
            folder = RESULTS / "links"
            hosts = (made.receiver, made.headset)
            (loaded,) = load_run(CONFIG, folder, duration_s, hosts=hosts)
        finally:
            over.set()
            changing.join()
        return _row(loaded, rate_mbit, congestion) | {"packets_dropped": made.dropped()}


def _row(loaded: Loaded, rate_mbit: float, congestion: str) -> dict[str, Any]:
    topics = loaded.final["topics"]
    imu = topics[f"{PREFIX}/imu_left/imu"]
    world = [topics[f"{PREFIX}/{camera}/image_raw"] for camera in WORLD]
    drops: dict[str, int] = {}
    for seen in topics.values():
        for key, count in seen["diagnostics"].items():
            if key.startswith("dropped."):
                drops[key[8:]] = drops.get(key[8:], 0) + int(count)
    sent_bytes = sum(seen["bytes"] for seen in topics.values())
    return {
        "link_mbit": rate_mbit,
        "rtt_ms": 0.1,
        "congestion": congestion,
        "config": "raw",
        "imu_p50_ms": imu["latency_ms"]["p50"],
        "imu_p99_ms": imu["latency_ms"]["p99"],
        "imu_p99_after_3_s_ms": imu["phases_ms"]["steady"]["p99"],
        "imu_lost": int(imu["diagnostics"].get("produced", imu["count"])) - imu["count"],
        "world_hz": [round(seen["rate_hz"], 1) for seen in world],
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
        made.limit(0.01, queue_bytes=100e6 / 8 * _QUEUE_S)
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


CHANGES = {"100, 20, 100": falls_and_rises, "stalls of 1 s": stalls, "another flow": competes}


def main(duration_s: float) -> None:
    if reason := why_not():
        raise SystemExit(f"{reason}: run make links as root on a machine with tc")
    rows = []
    began_s = time.monotonic()
    runs: list[tuple[float, str, float, str]] = [
        (rate, congestion, duration_s, "raw")
        for rate in (300.0, 100.0, 50.0, 30.0)
        for congestion in ("cubic", "bbr")
    ] + [(100.0, "cubic", 40.0, name) for name in CHANGES]
    for rate, congestion, run_s, name in runs:
        row = measure(rate, congestion, run_s, CHANGES.get(name, lambda *_: None))
        rows.append(row | {"config": name})
        print(f"{time.monotonic() - began_s:4.0f} s", json.dumps(rows[-1]), flush=True)
    RESULTS.mkdir(parents=True, exist_ok=True)
    (RESULTS / "links.json").write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main(float(sys.argv[1]))
