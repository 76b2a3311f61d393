"""How busy the processors are that the demo may use."""

from __future__ import annotations

import os
from dataclasses import dataclass

import psutil

_FULL_PERCENT = 90.0


@dataclass(frozen=True)
class Usage:
    """What the usable processors have done since the machine's start, in seconds.

    Attributes:
        usable: processors that this process may run on.
        existing: processors of the machine.
        busy_s: work of all programs on the usable ones.
        passed_s: busy and idle time of the usable ones.
    """

    usable: int
    existing: int
    busy_s: float
    passed_s: float


def usage() -> Usage:
    """The present usage. Any thread."""
    every = psutil.cpu_times(percpu=True)
    usable = [every[index] for index in sorted(os.sched_getaffinity(0)) if index < len(every)]
    # The kernel counts a guest's time as its user's or nice's, too.
    passed_s = sum(sum(it) - it.guest - it.guest_nice for it in usable)
    idle_s = sum(it.idle + it.iowait for it in usable)
    return Usage(len(usable), len(every), passed_s - idle_s, passed_s)


def warning(before: Usage, after: Usage) -> str | None:
    """Says that the processors were full between two usages; None if they were not."""
    passed_s = after.passed_s - before.passed_s
    if passed_s <= 0:
        return None
    percent = 100 * (after.busy_s - before.busy_s) / passed_s
    if percent < _FULL_PERCENT:
        return None
    processors = f"{after.usable} of {after.existing} processors"
    return f"{processors} {percent:.0f} % busy: latencies are this machine's"


class Load:
    """The warning of the time in which messages arrive. One thread."""

    def __init__(self) -> None:
        self._messages = 0
        self._began: Usage | None = None
        self._warning: str | None = None

    def note(self, messages: int) -> str | None:
        """Measures up to now, if messages have arrived; returns the warning so far.

        Args:
            messages: how many have arrived since the start.
        """
        if messages > self._messages:
            self._messages = messages
            now = usage()
            self._began = self._began or now
            self._warning = warning(self._began, now)
        return self._warning
