"""Splits the latency of a topic's messages into stages, from /diagnostics and a subscriber."""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ml2_receiver.session.statistics import SHARES, Latency

# Enough for four windows of the receiver: a row is evaluated when the next one arrives.
_ARRIVALS = 2048


@dataclass(frozen=True)
class Breakdown:
    """The latency by stage, over all windows whose messages all reached this subscriber.

    Attributes:
        messages: the number of messages.
        shares_ms: the mean of each stage: SHARES, then published to subscriber. They add up to the
            mean of `total`.
        total: the latency from capture to subscriber.
    """

    messages: int
    shares_ms: tuple[float, ...]
    total: Latency


@dataclass(frozen=True)
class _Window:
    """The messages of one row of /diagnostics.

    Attributes:
        shares_ms: the means of SHARES, as the receiver reports them.
        latencies_ms: each message's latency, as this subscriber measured it.
    """

    shares_ms: tuple[float, ...]
    latencies_ms: NDArray[np.float64]


class TopicLatency:
    """The latency of one topic at a subscriber. Not thread-safe.

    Args:
        windows: the number of latest rows of /diagnostics that a breakdown is made of.
    """

    def __init__(self, stream: str, windows: int) -> None:
        self.stream = stream
        self._arrivals: deque[tuple[int, float]] = deque(maxlen=_ARRIVALS)
        self._windows: deque[_Window] = deque(maxlen=windows)
        self._last_row: Mapping[str, str] = {}

    def arrived(self, stamp_ns: int, now_ns: int) -> None:
        """Takes the stamp of a message and the time of its arrival; both are ROS time."""
        self._arrivals.append((stamp_ns, (now_ns - stamp_ns) / 1e6))

    def reported(self, row: Mapping[str, str]) -> None:
        """Takes a row of /diagnostics.

        The row is evaluated when the next one arrives, because its messages may arrive later.
        """
        window = self._window(self._last_row)
        self._last_row = row
        if window is not None:
            self._windows.append(window)

    def _window(self, row: Mapping[str, str]) -> _Window | None:
        """Returns the window of a row; None if it names none, or some messages did not arrive."""
        try:
            ends_ns = int(row["window.first_capture_ns"]), int(row["window.last_capture_ns"])
            count = int(row["window.messages"])
            shares_ms = tuple(float(row[f"window.{share}_ms"]) for share in SHARES)
        except (KeyError, ValueError):
            return None
        if count < 1 or not all(map(math.isfinite, shares_ms)):
            return None
        arrivals = list(self._arrivals)
        for end in range(len(arrivals), count - 1, -1):
            if (arrivals[end - count][0], arrivals[end - 1][0]) == ends_ns:
                latencies_ms = [ms for _, ms in arrivals[end - count : end]]
                return _Window(shares_ms, np.array(latencies_ms))
        return None

    def breakdown(self) -> Breakdown | None:
        """Returns the latency by stage, or None before the first complete window."""
        if not self._windows:
            return None
        latencies_ms = np.concatenate([window.latencies_ms for window in self._windows])
        counts = [len(window.latencies_ms) for window in self._windows]
        shares_ms = np.average([w.shares_ms for w in self._windows], axis=0, weights=counts)
        last_ms = latencies_ms.mean() - shares_ms.sum()
        return Breakdown(sum(counts), (*shares_ms.tolist(), last_ms), Latency.of(latencies_ms))
