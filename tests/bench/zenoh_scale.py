"""Measures one Zenoh router with sessions of many headsets: CPU, memory, discovery, and the end.

Usage: zenoh_scale.py RESULTS SECONDS SESSIONS. The router is a session of eclipse-zenoh in mode
`router`. `load` has a row for each number of headsets, which send 2000 inertial samples per second
each to one subscriber: CPU of the router, and what arrived. `sessions` has so many sessions with
all topics of a headset: what they add to the router's memory, how long a program takes to list
their topics, and what is left after they were killed.
"""

import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import psutil

from ml2_receiver.table.reader import load_table
from zenoh_bench import role
from zenoh_peers import free_endpoint, open_client
from zenoh_roles import EVERYTHING

_HEADSETS = (1, 2, 4, 8)
_SAMPLES_PER_S = 2000
_TOKENS = "@ros2_lv/0/**"
# Its node, its streams' topics, those of the receiver, and /diagnostics.
_TOKENS_OF_A_HEADSET = (
    sum(len(stream.topics) for stream in load_table().streams.values())
    + len(load_table().receiver_topics)
    + 2
)
_MOST_S = 60.0


def main(results_file: Path, duration_s: float, number: int) -> None:
    load_average = os.getloadavg()[0]
    results: dict[str, Any] = {
        "load": [load(headsets, duration_s) for headsets in _HEADSETS],
        "sessions": sessions(number),
        "load_average_before": load_average,
    }
    results_file.parent.mkdir(parents=True, exist_ok=True)
    results_file.write_text(json.dumps(results, indent=2) + "\n")


def load(number: int, duration_s: float) -> dict[str, float]:
    endpoint, arrived = free_endpoint(), 0

    def take(_: object) -> None:
        nonlocal arrived
        arrived += 1

    with role("route", endpoint) as router, open_client(endpoint) as session:
        session.declare_subscriber(EVERYTHING, take)
        with role("headsets", endpoint, str(number), str(_SAMPLES_PER_S)):
            process = psutil.Process(router.pid)
            time.sleep(1)
            before, arrived_before, began_s = _cpu_s(process), arrived, time.monotonic()
            time.sleep(duration_s)
            elapsed_s = time.monotonic() - began_s
            return {
                "headsets": number,
                "router_cpu_percent": 100 * (_cpu_s(process) - before) / elapsed_s,
                "samples_per_s": (arrived - arrived_before) / elapsed_s,
            }


def sessions(number: int) -> dict[str, float]:
    endpoint = free_endpoint()
    with role("route", endpoint) as router:
        process = psutil.Process(router.pid)
        empty = process.memory_info().rss
        began_s = time.monotonic()
        with role("headsets", endpoint, str(number), "0") as headsets:
            opened_s = time.monotonic() - began_s
            while tokens(endpoint) < number * _TOKENS_OF_A_HEADSET:
                assert time.monotonic() - began_s < opened_s + _MOST_S
            full = process.memory_info().rss
            began_s = time.monotonic()
            found = tokens(endpoint)
            discovered_s = time.monotonic() - began_s
            headsets.kill()
        began_s = time.monotonic()
        while (left := tokens(endpoint)) and time.monotonic() - began_s < _MOST_S:
            time.sleep(0.1)
        return {
            "sessions": number,
            "opened_s": opened_s,
            "tokens": found,
            "router_kb_per_session": (full - empty) / number / 1e3,
            "discovery_s": discovered_s,
            "gone_s": time.monotonic() - began_s,
            "tokens_left": left,
            "router_mb_left": (process.memory_info().rss - empty) / 1e6,
        }


def tokens(endpoint: str) -> int:
    """The number of nodes and publishers that a program which comes now finds."""
    with open_client(endpoint) as session:
        replies: Any = session.liveliness().get(_TOKENS, timeout=_MOST_S)
        return sum(reply.ok is not None for reply in replies)


def _cpu_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return times.user + times.system


if __name__ == "__main__":
    main(Path(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3]))
