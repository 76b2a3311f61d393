"""The results of the demo, as build/demo/report.json and as a verdict."""

from typing import Any

_DROPPED = "dropped."


def build_report(final: dict[str, Any], source: str) -> dict[str, Any]:
    """The report of a final snapshot of the observer.

    Drops are what the device produced, by its final STATUS, less what the observer received. Their
    reasons are those of PROTOCOL.md; a drop between receiver and observer has none.
    """
    clock = final["clock"]
    topics = {name: _topic(seen) for name, seen in sorted(final["topics"].items())}
    arrived = [seen for seen in final["topics"].values() if seen["count"]]
    return {
        "duration_s": max((seen["last_s"] - seen["first_s"] for seen in arrived), default=0.0),
        "source": source,
        "topics": topics,
        "clock": {
            "offset_s": int(clock.get("offset_ns", 0)) * 1e-9,
            "uncertainty_s": int(clock.get("uncertainty_ns", 0)) * 1e-9,
        },
    }


def drops(seen: dict[str, Any]) -> int:
    """Messages the device has produced so far that the observer has not received."""
    return int(seen["diagnostics"].get("produced", seen["count"])) - int(seen["count"])


def verdict(final: dict[str, Any], is_simulated: bool) -> list[str]:
    """Returns the demo's failures, empty if there are none."""
    streams, topics = final["streams"], final["topics"]
    refused = {name: row["reason"] for name, row in streams.items() if row["result"] == "refused"}
    failures = [f"{name}: nothing arrived" for name, seen in topics.items() if not seen["count"]]
    if len(refused) == len(streams):
        failures.append("no stream was accepted")
    if is_simulated:
        failures += [f"{name} was refused: {reason}" for name, reason in refused.items()]
    return failures


def _topic(seen: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": seen["type"],
        "count": seen["count"],
        "rate_hz": seen["rate_hz"],
        "drops": drops(seen),
        "drops_by_reason": {
            key.removeprefix(_DROPPED): int(count)
            for key, count in seen["diagnostics"].items()
            if key.startswith(_DROPPED)
        },
        "latency_ms": seen["latency_ms"],
    }
