"""Measures how busy the processors are that the demo may use."""

import os
from dataclasses import dataclass

import psutil

_FULL_PERCENT = 90.0


@dataclass(frozen=True)
class Usage:
    """Times of processors since the machine's start, in seconds.

    Attributes:
        usable: the number of processors that this process may use.
        existing: the number of processors of the machine.
        busy_s: the time that all programs had on the usable ones.
        passed_s: that time and the idle time.
    """

    usable: int
    existing: int
    busy_s: float
    passed_s: float


def usage() -> Usage:
    """Reads the present usage. Thread-safe."""
    every = psutil.cpu_times(percpu=True)
    usable = [every[index] for index in sorted(os.sched_getaffinity(0)) if index < len(every)]
    # The kernel counts a guest's time as its user's or nice's, too.
    passed_s = sum(sum(it) - it.guest - it.guest_nice for it in usable)
    idle_s = sum(it.idle + it.iowait for it in usable)
    return Usage(len(usable), len(every), passed_s - idle_s, passed_s)


def warning(before: Usage, after: Usage) -> str | None:
    """Returns a warning if the processors were full between two usages; None if they were not."""
    passed_s = after.passed_s - before.passed_s
    if passed_s <= 0:
        return None
    percent = 100 * (after.busy_s - before.busy_s) / passed_s
    if percent < _FULL_PERCENT:
        return None
    processors = f"{after.usable} of {after.existing} processors"
    return f"{processors} {percent:.0f} % busy: latencies are this machine's"


class Load:
    """Warns if the processors are full while messages arrive. Not thread-safe."""

    def __init__(self) -> None:
        self._messages = 0
        self._began: Usage | None = None
        self._warning: str | None = None

    def note(self, messages: int) -> str | None:
        """Measures until now if messages have arrived since the last call.

        Args:
            messages: the number since the start.

        Returns:
            the warning, or None, of the time until the last message.
        """
        if messages > self._messages:
            self._messages = messages
            now = usage()
            self._began = self._began or now
            self._warning = warning(self._began, now)
        return self._warning
