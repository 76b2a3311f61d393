"""Where the time of a topic's messages goes: what /diagnostics says, and what a subscriber saw."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ml2_receiver.session.statistics import SHARES, Latency

# Four of the receiver's windows: a row is compared when the next one is here.
_ARRIVALS = 2048


@dataclass(frozen=True)
class Breakdown:
    """Of `messages` messages, in ms: those of every window of which none was lost on the way here.

    `shares_ms` are means and add up to the mean of the whole: SHARES, then published to
    subscriber. `total` is of the whole, capture to subscriber.
    """

    messages: int
    shares_ms: tuple[float, ...]
    total: Latency


@dataclass(frozen=True)
class _Window:
    """The same messages at both ends: means of SHARES, and each one's latency."""

    shares_ms: tuple[float, ...]
    latencies_ms: NDArray[np.float64]


class TopicLatency:
    """One topic as a subscriber sees it. Not thread-safe.

    Args:
        windows: rows of /diagnostics that a breakdown is made of, the last ones.
    """

    def __init__(self, stream: str, windows: int) -> None:
        self.stream = stream
        self._arrivals: deque[tuple[int, float]] = deque(maxlen=_ARRIVALS)
        self._windows: deque[_Window] = deque(maxlen=windows)
        self._last_row: Mapping[str, str] = {}

    def arrived(self, stamp_ns: int, now_ns: int) -> None:
        """A message with this stamp is in the subscriber's hands; both are ROS time."""
        self._arrivals.append((stamp_ns, (now_ns - stamp_ns) / 1e6))

    def reported(self, row: Mapping[str, str]) -> None:
        """A row of /diagnostics came. It counts when the next comes: messages take their time."""
        window = self._window(self._last_row)
        self._last_row = row
        if window is not None:
            self._windows.append(window)

    def _window(self, row: Mapping[str, str]) -> _Window | None:
        """None without messages, or when not all of them arrived here."""
        if f"window.{SHARES[0]}_ms" not in row:
            return None
        ends_ns = int(row["window.first_capture_ns"]), int(row["window.last_capture_ns"])
        arrivals, count = list(self._arrivals), int(row["window.messages"])
        for end in range(len(arrivals), count - 1, -1):
            if (arrivals[end - count][0], arrivals[end - 1][0]) == ends_ns:
                shares_ms = tuple(float(row[f"window.{share}_ms"]) for share in SHARES)
                latencies_ms = [ms for _, ms in arrivals[end - count : end]]
                return _Window(shares_ms, np.array(latencies_ms))
        return None

    def breakdown(self) -> Breakdown | None:
        """None before the first whole window."""
        if not self._windows:
            return None
        latencies_ms = np.concatenate([window.latencies_ms for window in self._windows])
        counts = [len(window.latencies_ms) for window in self._windows]
        shares_ms = np.average([w.shares_ms for w in self._windows], axis=0, weights=counts)
        last_ms = latencies_ms.mean() - shares_ms.sum()
        return Breakdown(sum(counts), (*shares_ms.tolist(), last_ms), Latency.of(latencies_ms))
