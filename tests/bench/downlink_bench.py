"""Measures messages to the headset's app, beside the demo's sensors, with TLS.

Those are 1000 small ones per second, 20 of 1 MB, or one of 16 MiB. Each kind takes turns with
nothing, since the speed of a machine changes within minutes.

Usage: downlink_bench.py DURATION, in seconds: the time of a kind's turns. Writes
build/bench/downlink.json, by kind:

latency_p50_ms  from the call of publish() to the line that the headset's app prints; also p99, max
lost            messages that were published and not printed
imu_p99_ms      from capture to a subscriber of ROS meanwhile, also p50 and p999: means of the turns
imu_without_... the same in the turns with nothing
busy_percent    of all processors together; busy_without_percent
receiver_cpu_us_per_message, headset_cpu_us_per_message: the CPU time that the topic adds
book            the counts of receiver and app
rss_mb          the receiver's greatest so far

The publishers are processes of their own. One writes CLOCK_MONOTONIC into each message of
100 bytes. This process reads the same clock when it has read the line. Of large messages it takes
the time that ROS gave them.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import psutil
import yaml

from load_run import Usage
from ml2_tools.live.diagnostics_node import DiagnosticsNode
from players import Player
from processes import (
    PREFIX,
    ROOT,
    draw_images,
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    paired,
    process,
    receive_command,
)
from simulation import compressed_config

RESULTS = ROOT / "build" / "bench" / "downlink.json"
LARGE_TYPE = "std_msgs/msg/UInt8MultiArray"


class Kind(NamedTuple):
    """Messages of one topic; `length` is in bytes without those of the layout, 0 for small ones."""

    topic: str
    type: str
    rate_hz: int
    length: int


SMALL = Kind("/bench/of_100_b", "std_msgs/msg/String", 1000, 0)
KINDS = (
    SMALL,
    Kind("/bench/of_1_mb", LARGE_TYPE, 20, 1_000_000),
    Kind("/bench/of_16_mib", LARGE_TYPE, 1, (16 << 20) - 16),
)
_TURNS = 4
_IMU = f"{PREFIX}/gyro_left/imu"
_IMU_FIGURES = {"p50": 50, "p99": 99, "p999": 99.9}
_TIMEOUT_S = 60.0
_WARM_UP_S = 10.0
_LINE = re.compile(SMALL.topic + r' \d+ \d+ \{"data":"(\d+)')
_LARGE_LINE = re.compile(r"(/bench/\w+) \d+ (\d+) of \d+ bytes")


class Arrivals:
    """The latency of each message that the headset prints, by topic; a thread reads the lines."""

    def __init__(self, headset: subprocess.Popen[str]) -> None:
        self.latencies_ns: dict[str, list[int]] = {kind.topic: [] for kind in KINDS}
        self._headset = headset
        self._changed = threading.Condition()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in lines(self._headset):
            now_ns = time.monotonic_ns()
            if (found := _LINE.match(line)) is not None:
                self._add(SMALL.topic, now_ns - int(found[1]))
            elif (found := _LARGE_LINE.match(line)) is not None:
                self._add(found[1], time.time_ns() - int(found[2]))

    def _add(self, topic: str, latency_ns: int) -> None:
        with self._changed:
            self.latencies_ns[topic].append(latency_ns)
            self._changed.notify()

    def take(self, topic: str, count: int) -> list[int]:
        """Waits until so many messages have arrived, or none comes any more; forgets them."""
        latencies_ns = self.latencies_ns[topic]
        with self._changed:
            while len(latencies_ns) < count and self._changed.wait(_WARM_UP_S):
                pass
            taken, latencies_ns[:] = list(latencies_ns), []
        return taken


def main(duration_s: float) -> None:
    os.environ |= isolated_environment()
    with tempfile.TemporaryDirectory(prefix="ml2_downlink") as name, ExitStack() as stack:
        folder, logs = Path(name), RESULTS.with_suffix("")
        config = folder / "config.yaml"
        logs.mkdir(parents=True, exist_ok=True)
        config.write_text(_config())
        draw_images(config, ())
        keys = paired(folder)
        command = receive_command(config, "127.0.0.1:0", security=keys)
        receiver = stack.enter_context(process(command, dict(os.environ), logs / "receiver.log"))
        address = listening_address(receiver)
        subscribe = (word for kind in KINDS for word in ("--subscribe", kind.topic, kind.type))
        command = headset_command(address, *subscribe, security=keys)
        headset = stack.enter_context(process(command, dict(os.environ), logs / "headset.log"))
        arrivals = Arrivals(headset)
        imu = stack.enter_context(Player("ages", _IMU, "sensor_msgs/msg/Imu"))
        imu.line()
        publishers = [_publisher(stack, kind, arrivals) for kind in KINDS]
        time.sleep(_WARM_UP_S)
        pids = {"receiver": receiver.pid, "headset": headset.pid}
        results: dict[str, Any] = {"duration_s": duration_s, "turns": _TURNS}
        for kind, publisher in zip(KINDS, publishers, strict=True):
            of_kind = _turns(kind, publisher, arrivals, imu, pids, duration_s / _TURNS)
            results[Path(kind.topic).name] = of_kind
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")


def _publisher(stack: ExitStack, kind: Kind, arrivals: Arrivals) -> Player:
    """Starts a publisher, whose first second, slower as that of any program, has passed."""
    arguments = kind.topic, str(kind.rate_hz), str(kind.length or "")
    publisher = stack.enter_context(Player("publisher", *arguments))
    publisher.line()
    publisher.usage(kind.rate_hz)
    arrivals.take(kind.topic, kind.rate_hz)
    return publisher


def _turns(
    kind: Kind,
    publisher: Player,
    arrivals: Arrivals,
    imu: Player,
    pids: dict[str, int],
    turn_s: float,
) -> dict[str, Any]:
    messages = round(turn_s * kind.rate_hz)
    latencies_ns, lost = list[int](), 0
    without, beside = list[dict[str, float]](), list[dict[str, float]]()
    for _ in range(_TURNS):
        with _measured(imu, pids) as figures:
            time.sleep(turn_s)
        without.append(figures)
        with _measured(imu, pids) as figures:
            publisher.usage(messages)
            arrived_ns = arrivals.take(kind.topic, messages)
        beside.append(figures)
        latencies_ns += arrived_ns
        lost += messages - len(arrived_ns)
    p50, p99, longest = np.percentile(latencies_ns, (50, 99, 100)) / 1e6
    means, means_without = _means(beside), _means(without)
    status = Path(f"/proc/{pids['receiver']}/status").read_text()
    return {
        "latency_p50_ms": p50,
        "latency_p99_ms": p99,
        "latency_max_ms": longest,
        "lost": lost,
        **{f"imu_without_{it}_ms": means_without[it] for it in _IMU_FIGURES},
        **{f"imu_{it}_ms": means[it] for it in _IMU_FIGURES},
        "busy_without_percent": means_without["busy"],
        "busy_percent": means["busy"],
        **{
            f"{role}_cpu_us_per_message": (means[role] - means_without[role]) * 1e4 / kind.rate_hz
            for role in pids
        },
        "rss_mb": int(status.partition("VmHWM:")[2].split()[0]) / 1e3,
        "book": _book(kind.topic),
    }


def _means(turns: list[dict[str, float]]) -> dict[str, float]:
    return {name: float(np.mean([turn[name] for turn in turns])) for name in turns[0]}


def _config() -> str:
    tree = yaml.safe_load(compressed_config())
    (node,) = tree.values()
    node["ros__parameters"]["app"] = {"subscribe": [kind.topic for kind in KINDS]}
    return yaml.safe_dump(tree)


@contextmanager
def _measured(imu: Player, pids: dict[str, int]) -> Iterator[dict[str, float]]:
    """Measures while the caller acts: the IMU's latency, and CPU by process and of the machine."""
    figures: dict[str, float] = {}
    usage = {role: Usage(pid) for role, pid in pids.items()}
    imu.answer()
    psutil.cpu_percent()
    for each in usage.values():
        each.sample()
    yield figures
    ages_ms = np.percentile(imu.answer(), list(_IMU_FIGURES.values()))
    figures |= zip(_IMU_FIGURES, map(float, ages_ms), strict=True)
    figures["busy"] = psutil.cpu_percent()
    for role, each in usage.items():
        each.sample()
        figures[role] = each.cpu_percent


def _book(topic: str) -> dict[str, int]:
    """Returns the counts of the receiver and the app."""
    diagnostics = DiagnosticsNode()
    try:
        row = diagnostics.rows("", _TIMEOUT_S)[f"subscription {topic}"]
    finally:
        diagnostics.close()
    return {what: int(value) for what, value in row.items() if value.isdecimal() and what != "id"}


if __name__ == "__main__":
    main(float(sys.argv[1]))
