"""The plots of the page: where their values come from, and the values of the last 30 s."""

import math
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from ..monitoring.topic_table import Rows, number_of

type Values = tuple[float | None, ...]

SHOWN_S = 30
_MOST_HZ = 50
_MICRO, _HECTO = 1e6, 1e-2


@dataclass(frozen=True)
class Plot:
    """A plot of messages. `streams` are those that can fill it, the first choice first."""

    name: str
    unit: str
    streams: tuple[str, ...]
    read: Callable[[Any], Sequence[float]]


def _vector(vector: Any, scale: float = 1) -> Sequence[float]:
    return vector.x * scale, vector.y * scale, vector.z * scale


_SENSOR_PLOTS = (
    Plot(
        "gyroscope",
        "rad/s",
        ("gyro_left", "gyro_right", "gyro_compute_pack", "imu_left", "imu_right"),
        lambda it: _vector(it.angular_velocity),
    ),
    Plot(
        "accelerometer",
        "m/s²",
        ("accel_left", "accel_right", "accel_compute_pack", "imu_left", "imu_right"),
        lambda it: _vector(it.linear_acceleration),
    ),
    Plot(
        "magnetometer",
        "µT",
        ("magnetometer_left", "magnetometer_right"),
        lambda it: _vector(it.magnetic_field, _MICRO),
    ),
    Plot("light", "lx", ("light_sensor",), lambda it: (it.illuminance,)),
    Plot(
        "pressure",
        "hPa",
        ("pressure_headset", "pressure_compute_pack"),
        lambda it: (it.fluid_pressure * _HECTO,),
    ),
)
SENSOR_PLOTS = {it.name: it for it in _SENSOR_PLOTS}
CLOCK, THROUGHPUT = "clock uncertainty", "received"
# Each plot of the page with its unit, in the page's order.
UNITS = {it.name: it.unit for it in _SENSOR_PLOTS} | {CLOCK: "ms", THROUGHPUT: "Mbit/s"}


class Series:
    """The values of one plot of the last 30 s, at most 50 per second. Thread-safe.

    Times are in s on any clock.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last_s = -math.inf
        self._values: deque[tuple[float, Values]] = deque()
        # The number of all values and calls of forget(), now and at the last call of forget().
        self._count, self._forgotten = 0, 0

    def is_due(self, at_s: float) -> bool:
        """Returns True unless the last values are too new for others of this time."""
        return at_s >= self._last_s + 1 / _MOST_HZ

    def add(self, values: Sequence[float], at_s: float) -> None:
        """Adds values of a time; leaves them out if there are none, or if they are not due."""
        with self._lock:
            if not values or not self.is_due(at_s):
                return
            self._last_s, self._count = at_s, self._count + 1
            self._values.append((at_s, tuple(it if math.isfinite(it) else None for it in values)))
            while self._values[0][0] < at_s - SHOWN_S:
                self._values.popleft()

    def forget(self) -> None:
        """Forgets all values; who has them is told by a time without any values."""
        with self._lock:
            self._values.clear()
            self._last_s = -math.inf
            self._count = self._forgotten = self._count + 1

    def since(self, count: int) -> tuple[int, list[tuple[float, Values]]]:
        """Returns the count of all values so far, and those after the first `count`.

        A value is a time in s with numbers or None.
        """
        with self._lock:
            if count < self._forgotten:
                return self._count, [(0, ()), *self._values]
            old = max(0, len(self._values) - (self._count - count))
            return self._count, list(islice(self._values, old, None))


def clock_uncertainty_ms(rows: Rows) -> Sequence[float]:
    """Returns the uncertainty of stamps in ms; nothing if it is not known."""
    found = number_of(rows.get("clock", {}).get("uncertainty_ns"))
    return () if found is None else (found / 1e6,)


def received_mbit_per_s(rows: Rows) -> Sequence[float]:
    """Returns the throughput of all topics together in Mbit/s."""
    return (sum(number_of(it.get("mbit_per_s")) or 0 for it in rows.values()),)
