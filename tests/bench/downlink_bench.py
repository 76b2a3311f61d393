"""Measures messages to the headset's app, beside the demo's sensors, with TLS.

1000 small ones per second; then 20 of 1 MB, and one of 16 MiB.

Usage: downlink_bench.py DURATION, in seconds. Writes build/bench/downlink.json:

latency_p50_ms  from the call of publish() to the line that the headset's app prints; also p99, max
lost            messages that were published and not printed
rate_hz         messages that were published per second
imu_p99_ms      from capture to a subscriber of ROS meanwhile, also p999; imu_without_..., before
receiver_cpu_us_per_message, headset_cpu_us_per_message: the CPU time that the topic adds
book            the counts of receiver and app
of_1_mb_..., of_16_mib_...: the same of large messages; rss_mb is the receiver's greatest so far

The publisher is a process of its own. It writes CLOCK_MONOTONIC into each message of 100 bytes.
This process reads the same clock when it has read the line. Of large messages it takes the time
that ROS gave them.
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
from typing import Any

import numpy as np
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
TOPIC, TYPE = "/bench/downlink", "std_msgs/msg/String"
RATE_HZ = 1000
_IMU, _IMU_FIGURES = f"{PREFIX}/gyro_left/imu", ("p50", "p99", "p999")
_TIMEOUT_S = 60.0
_WARM_UP_S = 10.0
_LINE = re.compile(TOPIC + r' \d+ \d+ \{"data":"(\d+)')
# The rate in Hz, and bytes without those of the layout, by topic
LARGE_TYPE = "std_msgs/msg/UInt8MultiArray"
LARGE = {"/bench/of_1_mb": (20, 1_000_000), "/bench/of_16_mib": (1, (16 << 20) - 16)}
_LARGE_LINE = re.compile(r"(/bench/\w+) \d+ (\d+) of \d+ bytes")


class Arrivals:
    """The latency of each message that the headset prints; a thread reads the lines."""

    def __init__(self, headset: subprocess.Popen[str]) -> None:
        self.latencies_ns: list[int] = []
        self.of_large_ns: dict[str, list[int]] = {topic: [] for topic in LARGE}
        self._headset = headset
        self._changed = threading.Condition()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in lines(self._headset):
            now_ns = time.monotonic_ns()
            if (found := _LINE.match(line)) is not None:
                self._add(self.latencies_ns, now_ns - int(found[1]))
            elif (found := _LARGE_LINE.match(line)) is not None:
                self._add(self.of_large_ns[found[1]], time.time_ns() - int(found[2]))

    def _add(self, latencies_ns: list[int], latency_ns: int) -> None:
        with self._changed:
            latencies_ns.append(latency_ns)
            self._changed.notify()

    def wait(self, latencies_ns: list[int], count: int) -> None:
        """Waits until so many messages have arrived, or none comes any more."""
        with self._changed:
            while len(latencies_ns) < count and self._changed.wait(_WARM_UP_S):
                pass


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
        topics = {TOPIC: TYPE, **dict.fromkeys(LARGE, LARGE_TYPE)}
        subscribe = (word for topic in topics.items() for word in ("--subscribe", *topic))
        command = headset_command(address, *subscribe, security=keys)
        headset = stack.enter_context(process(command, dict(os.environ), logs / "headset.log"))
        arrivals = Arrivals(headset)
        publisher = stack.enter_context(Player("publisher", TOPIC, str(RATE_HZ)))
        publisher.line()
        imu = stack.enter_context(Player("ages", _IMU, "sensor_msgs/msg/Imu"))
        imu.line()
        publisher.usage(RATE_HZ)  # the first ones are slower, as those of any program
        arrivals.wait(arrivals.latencies_ns, RATE_HZ)
        time.sleep(_WARM_UP_S)
        pids = {"receiver": receiver.pid, "headset": headset.pid}
        with _measured(imu, pids) as without:
            time.sleep(duration_s)
        arrivals.latencies_ns.clear()
        messages = round(duration_s * RATE_HZ)
        with _measured(imu, pids) as with_topic:
            began_s = time.monotonic()
            publisher.usage(messages)
            passed_s = time.monotonic() - began_s
            arrivals.wait(arrivals.latencies_ns, messages)
        p50, p99, longest = np.percentile(arrivals.latencies_ns, (50, 99, 100)) / 1e6
        more_percent = {role: with_topic[role] - without[role] for role in pids}
        results = {
            "latency_p50_ms": p50,
            "latency_p99_ms": p99,
            "latency_max_ms": longest,
            "lost": messages - len(arrivals.latencies_ns),
            "rate_hz": messages / passed_s,
            **{f"imu_without_{it}_ms": without[it] for it in _IMU_FIGURES},
            **{f"imu_{it}_ms": with_topic[it] for it in _IMU_FIGURES},
            **{
                f"{role}_cpu_us_per_message": it * 1e4 / RATE_HZ
                for role, it in more_percent.items()
            },
            "book": _book(TOPIC),
            "duration_s": passed_s,
        }
        for topic in LARGE:
            results |= _large(topic, arrivals, imu, pids, duration_s)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")


def _large(
    topic: str, arrivals: Arrivals, imu: Player, pids: dict[str, int], duration_s: float
) -> dict[str, Any]:
    rate_hz, length = LARGE[topic]
    messages, latencies_ns = round(duration_s * rate_hz), arrivals.of_large_ns[topic]
    with Player("publisher", topic, str(rate_hz), str(length)) as publisher:
        publisher.line()
        publisher.usage(rate_hz)
        arrivals.wait(latencies_ns, rate_hz)
        latencies_ns.clear()
        with _measured(imu, pids) as figures:
            publisher.usage(messages)
            arrivals.wait(latencies_ns, messages)
    p50, p99, longest = np.percentile(latencies_ns, (50, 99, 100)) / 1e6
    status = Path(f"/proc/{pids['receiver']}/status").read_text()
    results = {
        "latency_p50_ms": p50,
        "latency_p99_ms": p99,
        "latency_max_ms": longest,
        "lost": messages - len(latencies_ns),
        **{f"imu_{it}_ms": figures[it] for it in _IMU_FIGURES},
        "rss_mb": int(status.partition("VmHWM:")[2].split()[0]) / 1e3,
        "book": _book(topic),
    }
    return {f"{Path(topic).name}_{what}": it for what, it in results.items()}


def _config() -> str:
    tree = yaml.safe_load(compressed_config())
    (node,) = tree.values()
    node["ros__parameters"]["app"] = {"subscribe": [TOPIC, *LARGE]}
    return yaml.safe_dump(tree)


@contextmanager
def _measured(imu: Player, pids: dict[str, int]) -> Iterator[dict[str, float]]:
    """Measures while the caller acts: the IMU's latency, and CPU by process."""
    figures: dict[str, float] = {}
    usage = {role: Usage(pid) for role, pid in pids.items()}
    imu.answer()
    for each in usage.values():
        each.sample()
    yield figures
    figures |= zip(_IMU_FIGURES, imu.answer(), strict=True)
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
