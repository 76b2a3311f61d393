"""Runs headsets, receivers and raw subscribers as processes and measures the load."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ml2_receiver.table.reader import load_table
from observed_topic import START_S
from processes import (
    PLAINTEXT,
    PREFIX,
    RECEIVER,
    ROOT,
    Security,
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
)
from proxy import Proxy
from shaped_link import Machine

OBSERVER = ROOT / "host_receiver" / "demo" / "observer.py"
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
# More messages than are ever in flight, so that missing ones were lost before the subscriber.
_DEPTH = 1000
# The headset reports its drops with this period.
_STATUS_S = 1.0
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


@dataclass
class Usage:
    """CPU time and memory of one process, sampled about once per second while messages flow."""

    pid: int
    times_s: list[float] = field(default_factory=list)
    cpu_s: list[float] = field(default_factory=list)
    rss_bytes: list[int] = field(default_factory=list)
    # Without files in memory: of the simulation's frames, those that were shown so far.
    anonymous_bytes: list[int] = field(default_factory=list)
    threads: list[int] = field(default_factory=list)
    files: list[int] = field(default_factory=list)

    def sample(self) -> None:
        folder = Path(f"/proc/{self.pid}")
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # it has ended
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
            if fields[0] == "Z":
                return
            _, resident, shared, *_ = map(int, (folder / "statm").read_text().split())
            files = len(list((folder / "fd").iterdir()))
            self.times_s.append(time.monotonic())
            self.cpu_s.append((int(fields[11]) + int(fields[12])) / _TICKS_PER_S)
            self.rss_bytes.append(resident * _PAGE_BYTES)
            self.anonymous_bytes.append((resident - shared) * _PAGE_BYTES)
            self.threads.append(int(fields[17]))
            self.files.append(files)

    @property
    def cpu_percent(self) -> float:
        """The CPU time in percent of one processor."""
        return 100 * (self.cpu_s[-1] - self.cpu_s[0]) / (self.times_s[-1] - self.times_s[0])

    @property
    def memory_mb_per_hour(self) -> float:
        """The slope of anonymous memory over the last three quarters of the time."""
        since = len(self.times_s) // 4
        hours = np.array(self.times_s[since:]) / 3600
        return float(np.polyfit(hours, np.array(self.anonymous_bytes[since:]) / 1e6, 1)[0])


def growth(counts: list[int]) -> float:
    """Returns the growth from the second tenth of the time to the last but one.

    Medians are compared, because connections open and close.
    """
    tenth = len(counts) // 10
    return statistics.median(counts[-2 * tenth : -1]) - statistics.median(counts[tenth : 2 * tenth])


@dataclass(frozen=True)
class Loaded:
    """The final snapshot of one headset's subscriber, and the usage of its processes.

    Attributes:
        drops_of_start: the drops that the headset had reported at the end of the start phase.
    """

    name: str
    final: dict[str, Any]
    usage: dict[str, Usage]
    drops_of_start: int

    @property
    def drops(self) -> int:
        """The messages of all topics that the headset produced and the subscriber did not get.

        With several headsets, /tf is shared and therefore not counted.
        """
        return sum(
            int(seen["diagnostics"].get("produced", seen["count"])) - int(seen["count"])
            for topic, seen in self.final["topics"].items()
            if topic.startswith(f"/{self.name}")
        )

    @property
    def duration_s(self) -> float:
        topics = [seen for seen in self.final["topics"].values() if seen["count"]]
        return max(float(seen["last_s"]) - float(seen["first_s"]) for seen in topics)

    @property
    def drops_after_start(self) -> int:
        """The drops after the start phase."""
        return self.drops - self.drops_of_start

    @property
    def latency_ms(self) -> dict[str, dict[str, dict[str, float]]]:
        """The latency from capture to subscriber, by phase and stream; of the slowest topic."""
        slowest: dict[str, dict[str, dict[str, float]]] = {"start": {}, "steady": {}}
        for seen in self.final["topics"].values():
            for phase, latency in seen["phases_ms"].items() if seen["count"] else ():
                known = slowest[phase].setdefault(seen["stream"], latency)
                slowest[phase][seen["stream"]] = max(known, latency, key=lambda it: it["p99"])
        return slowest


def load_run(
    config: Path,
    folder: Path,
    duration_s: float,
    names: tuple[str, ...] = ("",),
    record: Path | None = None,
    security: Security = PLAINTEXT,
    headset_options: tuple[str, ...] = (),
    java_options: str = "",
    link: Callable[[str], Proxy] | None = None,
    is_enough: Callable[[dict[str, Any]], bool] = lambda _: False,
    hosts: tuple[Machine, Machine] = (Machine(), Machine()),
    environment: dict[str, str] | None = None,
) -> list[Loaded]:
    """Runs one headset per name at the same time; an empty name means none.

    Args:
        folder: the folder for logs.
        headset_options: more options of the headsets.
        java_options: more options of their Java.
        link: makes the proxy between headset and receiver, from the receiver's address.
        is_enough: ends a headset's run before `duration_s` when it returns True for its
            subscriber's snapshot, of which there is one about each second.
        hosts: that of receiver and subscriber, and that of the headset.
        record: the folder for a recording of the only receiver, or None.
        environment: that of the processes; without it, one with a ROS domain of its own.
    """
    environment = environment or isolated_environment()
    if java_options:
        environment["JAVA_TOOL_OPTIONS"] = java_options
    with contextlib.ExitStack() as stack:
        started = [
            _start(
                stack,
                environment,
                config,
                folder / (name or "one"),
                name,
                ("--duration", f"{duration_s}", "--seed", f"{seed}", *headset_options),
                record,
                security,
                link,
                hosts,
            )
            for seed, name in enumerate(names, start=1)
        ]
        # Reads all observers at the same time, so that none blocks on a full pipe
        with ThreadPoolExecutor(len(started)) as pool:
            watch = partial(_watch, is_enough)
            return list(pool.map(watch, names, *zip(*started, strict=True)))


def _start(
    stack: contextlib.ExitStack,
    environment: dict[str, str],
    config: Path,
    folder: Path,
    name: str,
    headset_options: tuple[str, ...],
    record: Path | None,
    security: Security,
    link: Callable[[str], Proxy] | None,
    hosts: tuple[Machine, Machine],
) -> tuple[subprocess.Popen[str], dict[str, Usage]]:
    folder.mkdir(parents=True, exist_ok=True)
    options = ("--start-paused", "--name", name)
    near, far = hosts
    receive = receive_command(config, f"{near.address}:0", *options, security=security)
    if record is not None:
        receive = [RECEIVER, "record", record, *receive[2:]]
    receiver = stack.enter_context(
        process([*near.prefix, *receive], environment, folder / "receiver.log")
    )
    observe: list[str | Path] = [
        *(sys.executable, OBSERVER, "--prefix", f"/{name}{PREFIX}" if name else PREFIX),
        *("--qos-depths", json.dumps(dict.fromkeys(load_table().qos, _DEPTH))),
        *("--pictures", folder / "streams.png", "--arrivals", folder / "arrivals.npz"),
        *("--receiver", name),
    ]
    observer = stack.enter_context(
        process([*near.prefix, *observe], environment, folder / "observer.log")
    )
    address = listening_address(receiver)
    if link is not None:
        address = stack.enter_context(link(address)).address
    send = [*far.prefix, *headset_command(address, *headset_options, security=security)]
    headset = stack.enter_context(process(send, environment, folder / "headset.log", is_read=False))
    children = {"receiver": receiver, "headset": headset, "subscriber": observer}
    return observer, {role: Usage(child.pid) for role, child in children.items()}


def _watch(
    is_enough: Callable[[dict[str, Any]], bool],
    name: str,
    observer: subprocess.Popen[str],
    usage: dict[str, Usage],
) -> Loaded:
    final = None
    drops_of_start = 0
    has_enough = False
    for snapshot in _snapshots(observer):
        for each in usage.values():
            each.sample()
        final = snapshot if snapshot["final"] else None
        if not has_enough and is_enough(snapshot):
            has_enough = True
            os.kill(usage["headset"].pid, signal.SIGTERM)
        if age_s(snapshot) < START_S + _STATUS_S:
            drops_of_start = _counted_drops(snapshot, name)
    if final is None:
        raise SystemExit("a process ended early: see the logs")
    return Loaded(name, final, usage, drops_of_start)


def age_s(snapshot: dict[str, Any]) -> float:
    """Returns the time since the first message."""
    topics = [seen for seen in snapshot["topics"].values() if seen["count"]]
    if not topics:
        return 0.0
    begin_s, end_s = (
        min(it["first_s"] for it in topics),
        max(it["last_s"] for it in topics),
    )
    return float(end_s - begin_s)


def _counted_drops(snapshot: dict[str, Any], name: str) -> int:
    """Returns the drops that the headset has reported."""
    return sum(
        int(count)
        for topic, seen in snapshot["topics"].items()
        for key, count in seen["diagnostics"].items()
        if topic.startswith(f"/{name}") and key.startswith("dropped.")
    )


def _snapshots(observer: subprocess.Popen[str]) -> Iterator[dict[str, Any]]:
    for line in lines(observer):
        yield json.loads(line)
