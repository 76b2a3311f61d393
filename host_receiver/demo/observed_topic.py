"""The messages of one topic that the demo's witness has seen."""

import time
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

# After its first message a topic is starting for so long: programs are still being compiled.
START_S = 3.0


@dataclass
class Observed:
    """The messages of one topic; times in seconds of this process's wall clock."""

    type: str
    stream: str
    read_stamp: Callable[[bytes], int]
    count: int = 0
    size_bytes: int = 0
    first_s: float = 0.0
    last_s: float = 0.0
    last_payload: bytes = b""
    start_count: int = 0
    last_stamp_ns: int = 0
    received_s: array[float] = field(default_factory=lambda: array("d"))
    latencies_ms: array[float] = field(default_factory=lambda: array("d"))
    sizes_bytes: array[float] = field(default_factory=lambda: array("d"))
    gaps_ms: array[float] = field(default_factory=lambda: array("d"))

    def take(self, payload: bytes) -> None:
        """Counts one message, as it arrives."""
        now_ns, stamp_ns = time.time_ns(), self.read_stamp(payload)
        self.last_s = now_ns * 1e-9
        self.received_s.append(self.last_s)
        self.sizes_bytes.append(len(payload))
        if self.count == 0:
            self.first_s = self.last_s
        else:
            self.gaps_ms.append((stamp_ns - self.last_stamp_ns) * 1e-6)
        self.last_stamp_ns = stamp_ns
        self.count += 1
        self.start_count += self.last_s - self.first_s < START_S
        self.size_bytes += len(payload)
        self.last_payload = payload
        self.latencies_ms.append((now_ns - stamp_ns) * 1e-6)

    def arrivals(self) -> NDArray[np.float64]:
        """Returns a row for each message: arrival in seconds, latency in ms, size in bytes."""
        whole = len(self.latencies_ms)  # the one that is being taken is not
        # Copies, since an array whose memory is looked at cannot grow
        columns = (self.received_s[:whole], self.latencies_ms[:whole], self.sizes_bytes[:whole])
        return np.column_stack([np.array(column) for column in columns])

    def row(self) -> dict[str, Any]:
        span_s = self.last_s - self.first_s
        return {
            "type": self.type,
            "stream": self.stream,
            "count": self.count,
            "bytes": self.size_bytes,
            "first_s": self.first_s,
            "last_s": self.last_s,
            "rate_hz": (self.count - 1) / span_s if span_s > 0 else 0.0,
            "latency_ms": _percentiles(self.latencies_ms),
        }

    def gaps(self) -> dict[str, float]:
        """The times between successive stamps, after the first START_S seconds."""
        return _percentiles(self.gaps_ms[self.start_count :])

    def phases(self) -> dict[str, dict[str, float]]:
        """The latency of the first START_S seconds, and that of the rest."""
        return {
            "start": _percentiles(self.latencies_ms[: self.start_count]),
            "steady": _percentiles(self.latencies_ms[self.start_count :]),
        }


def _percentiles(times_ms: array[float]) -> dict[str, float]:
    # A copy, since an array whose memory is looked at cannot grow
    p50, p99, maximum = np.percentile(np.array(times_ms[:] or [0.0]), (50, 99, 100))
    return {"p50": float(p50), "p99": float(p99), "max": float(maximum)}
