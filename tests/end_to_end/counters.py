"""Looks at the counters of a headset, its receiver and their subscriber."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Callable, Mapping
from typing import Any

from processes import Received, full_name, lines
from waiting import LIMIT_S

# The counters that a subscriber prints four times per second; see observer.py.
type Snapshot = dict[str, Any]


def have_arrived(least: Mapping[str, int], of_others: int = 0) -> Callable[[Snapshot], bool]:
    """Returns a predicate of snapshots: at least so many messages of each topic have arrived."""
    named = {full_name(topic): count for topic, count in least.items()}

    def is_enough(snapshot: Snapshot) -> bool:
        topics = snapshot["topics"]
        return all(
            topics[it]["count"] >= named.get(it, of_others) for it in topics.keys() | named.keys()
        )

    return is_enough


def await_snapshot(
    subscriber: subprocess.Popen[str], is_enough: Callable[[Snapshot], bool]
) -> Snapshot:
    """Reads what a subscriber prints until a snapshot is enough, and returns that one."""
    deadline_s = time.monotonic() + LIMIT_S
    snapshot: Snapshot = {"session": {}, "topics": {}}
    for line in lines(subscriber):
        snapshot = json.loads(line)
        if is_enough(snapshot):
            return snapshot
        if time.monotonic() > deadline_s:
            break
    counts = {name: it["count"] for name, it in snapshot["topics"].items()}
    raise AssertionError(f"expected more within {LIMIT_S:g} s: {snapshot['session']}, {counts}")


def await_more(subscriber: subprocess.Popen[str], topic: str, count: int = 1) -> None:
    """Waits until so many more messages of a topic have arrived from now on."""
    name, now_s = full_name(topic), time.time()
    begun = await_snapshot(subscriber, lambda it: it["topics"][name]["last_s"] > now_s)
    await_snapshot(subscriber, have_arrived({name: begun["topics"][name]["count"] + count - 1}))


def assert_counters_agree(received: Received) -> None:
    """Asserts that every message arrived or was counted as dropped, and that some arrived."""
    for topic, seen in received.snapshot["topics"].items():
        counters = received.counters(topic)
        dropped = sum(int(n) for key, n in counters.items() if key.startswith("dropped."))
        assert int(counters["produced"]) == int(counters["received"]) + int(counters["gaps"]), topic
        assert int(counters["gaps"]) == dropped, topic
        assert 0 < seen["count"] <= int(counters["received"]), topic
