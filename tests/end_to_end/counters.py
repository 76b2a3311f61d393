"""Checks that the counters of a headset and its receiver agree."""

from __future__ import annotations

from processes import Received


def assert_counters_agree(received: Received) -> None:
    """Asserts that every message arrived or was counted as dropped, and that some arrived."""
    for topic, seen in received.snapshot["topics"].items():
        counters = received.counters(topic)
        dropped = sum(int(n) for key, n in counters.items() if key.startswith("dropped."))
        assert int(counters["produced"]) == int(counters["received"]) + int(counters["gaps"]), topic
        assert int(counters["gaps"]) == dropped, topic
        assert 0 < seen["count"] <= int(counters["received"]), topic
