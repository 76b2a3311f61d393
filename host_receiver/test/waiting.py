"""How long tests wait for what has to come, on however slow a machine."""

import os
import time
from collections.abc import Callable

# It only ends a hang. The Makefile sets it for all languages.
LIMIT_S = float(os.environ.get("ML2S_TEST_LIMIT_S", "120"))
# How long a child that was asked to end may take until it is asked more firmly.
GRACE_S = LIMIT_S / 8


def durations_s(shortest_s: float) -> tuple[float, float, float]:
    """How long to run what ends by time, one after another until it has shown enough."""
    return shortest_s, 5 * shortest_s, LIMIT_S


def await_true(is_true: Callable[[], bool]) -> None:
    """Asks again and again, where nothing tells when; fails when it does not come so."""
    deadline_s = time.monotonic() + LIMIT_S
    while not is_true():
        assert time.monotonic() < deadline_s
        time.sleep(0.01)
