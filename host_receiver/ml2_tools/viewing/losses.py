"""Counts the messages that topics have lost in the last seconds, and what apps use of ROS."""

from collections import deque
from collections.abc import Mapping
from typing import Any

from ml2_receiver.topics.diagnostics import CALLS, SUBSCRIPTION

from ..monitoring.topic_table import Rows, topic_figures

_RECENT_S = 10.0
_MOST_LISTED = 100
# The losses of a subscription: a message that a newer one supersedes is no loss.
_LOST = ("missed", "dropped.queue_full", "dropped.too_large", "dropped.link_down")

_BY = {"client": "ROS", "service": "the app"}  # who offers it


class RecentLosses:
    """The messages that each topic has lost in the last 10 s. Not thread-safe."""

    def __init__(self) -> None:
        self._counts: dict[str, deque[tuple[float, int]]] = {}

    def count(self, rows: Rows, now_s: float) -> Mapping[str, int]:
        """Takes the rows of /diagnostics of a time; returns the recent losses by topic.

        What was lost before a topic's first row is not recent.
        """
        lost = {it["topic"]: it["lost"] for it in topic_figures(rows) if it["lost"] is not None}
        self._counts = {topic: self._counts.get(topic, deque()) for topic in lost}
        for topic, counts in self._counts.items():
            if counts and lost[topic] < counts[-1][1]:  # a new session counts from 0
                counts.clear()
            counts.append((now_s, lost[topic]))
            # The first count that stays is that of 10 s ago.
            while len(counts) > 1 and counts[1][0] <= now_s - _RECENT_S:
                counts.popleft()
        return {topic: counts[-1][1] - counts[0][1] for topic, counts in self._counts.items()}


def losses_of(figures: Mapping[str, Any], recent: Mapping[str, int]) -> list[dict[str, Any]]:
    """Returns the topics that have lost messages, for JSON; the worst of the last 10 s first."""
    found = [
        {"topic": topic, "recent": recent.get(topic, 0), "all": it["lost"]}
        for topic, it in figures.items()
        if it["lost"]
    ]
    return sorted(found, key=lambda it: (-it["recent"], -it["all"], it["topic"]))[:_MOST_LISTED]


def subscriptions_of(rows: Rows) -> list[dict[str, Any]]:
    """Returns what apps on the headset subscribe to, with counts, for JSON."""
    return [
        {
            "topic": name.removeprefix(SUBSCRIPTION),
            "type": values.get("message_type", ""),
            "sent": values.get("sent", ""),
            "superseded": values.get("dropped.superseded", "0"),
            "lost": str(sum(int(values[it]) for it in _LOST if values.get(it, "").isdecimal())),
        }
        for name, values in rows.items()
        if name.startswith(SUBSCRIPTION)
    ]


def calls_of(rows: Rows) -> list[dict[str, Any]]:
    """Returns the services that apps on the headset call and offer, with counts, for JSON."""
    counts = ("requests", "responses", "failures")
    return [
        {"service": name.split(" ", 1)[1], "by": _BY[name.split(" ", 1)[0]]}
        | {"type": values.get("service_type", "")}
        | {it: values.get(it, "") for it in counts}
        for name, values in rows.items()
        if name.startswith(CALLS)
    ]
