"""Changes of a link, and how fast the streams over it follow."""

from __future__ import annotations

import itertools
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shaped_link import QUEUE_S, Link

# A later sample is not settled.
SETTLED_MS = 60
# The part of a link that images use when they fill it.
FILLED = 0.8
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
class Change:
    """From `at_s` of the wall clock a link has `rate_mbit`.

    It stands still with 0, and is shared with None.
    """

    at_s: float
    rate_mbit: float | None


def nothing(link: Link, over: threading.Event, changes: list[Change]) -> None:
    over.wait()


def falls_and_rises(link: Link, over: threading.Event, changes: list[Change]) -> None:
    """Changes 100 Mbit/s to 20 Mbit/s and back each 10 s."""
    for rate_mbit in itertools.cycle((20, 100)):
        if over.wait(10):
            return
        link.limit(rate_mbit)
        changes.append(Change(time.time(), rate_mbit))


def stalls(link: Link, over: threading.Event, changes: list[Change]) -> None:
    """Stops the link of 100 Mbit/s for a second each 5 s, seven times; its queue stays as long."""
    for _ in range(7):
        if over.wait(4):
            return
        changes.append(Change(time.time(), 0))
        link.limit(0.01, queue_bytes=100e6 / 8 * QUEUE_S)
        over.wait(1)
        link.limit(100)
        changes.append(Change(time.time(), 100))


def competes(link: Link, over: threading.Event, changes: list[Change]) -> None:
    """Sends as much as TCP can beside the headset, from 10 to 20 s of each 20 s."""
    at = (link.receiver.address, 7777)
    sink = [*link.receiver.prefix, sys.executable, "-c", _SINK.format(at)]
    with subprocess.Popen(sink) as taking:
        while not over.wait(10):
            source = [*link.headset.prefix, sys.executable, "-c", _SOURCE.format(at)]
            with subprocess.Popen(source) as sending:
                changes.append(Change(time.time(), None))
                over.wait(10)
                sending.kill()
            changes.append(Change(time.time(), 100))
        taking.kill()


def followed(
    changes: list[Change], imu: NDArray[np.float64], messages: NDArray[np.float64]
) -> list[dict[str, Any]]:
    """Returns how fast streams followed each change that left them a link, until the next one.

    `backlog_s` is how long after it the last sample of before came, `settled_s` the last sample
    that took more than SETTLED_MS, and `filled_s` the first second that uses FILLED of the link.
    A second that never came is None.

    Args:
        imu: samples of an IMU: arrival in seconds of the wall clock, latency in ms.
        messages: all messages: arrival, and size in bytes; by arrival.
    """
    ends_s = [change.at_s for change in changes[1:]] + [messages[-1, 0]]
    rows = []
    for change, end_s in zip(changes, ends_s, strict=True):
        if change.rate_mbit == 0:
            continue
        arrival_s, latency_ms = imu[(imu[:, 0] > change.at_s) & (imu[:, 0] <= end_s)].T
        of_before = arrival_s[arrival_s - latency_ms * 1e-3 < change.at_s]
        late = arrival_s[latency_ms > SETTLED_MS]
        rows.append(
            {
                "to_mbit": change.rate_mbit,
                "backlog_s": _after(change, of_before),
                "settled_s": _after(change, late),
                "filled_s": _filled_s(change, end_s, messages),
            }
        )
    return rows


def _after(change: Change, arrivals_s: NDArray[np.float64]) -> float:
    return float(arrivals_s.max(initial=change.at_s)) - change.at_s


def _filled_s(change: Change, end_s: float, messages: NDArray[np.float64]) -> float | None:
    if change.rate_mbit is None:
        return None
    arrival_s, sizes = messages.T
    total = np.concatenate(([0.0], np.cumsum(sizes)))
    begins_s = np.arange(change.at_s, end_s - 1, 0.1)
    within = np.searchsorted(arrival_s, begins_s + 1), np.searchsorted(arrival_s, begins_s)
    mbit = (total[within[0]] - total[within[1]]) * 8e-6
    filled = begins_s[mbit >= FILLED * change.rate_mbit]
    return float(filled[0] - change.at_s) if filled.size else None
