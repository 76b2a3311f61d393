"""Waits of tests for what has to come, on however slow a machine."""

import os
import threading
import time
from collections.abc import Callable
from typing import Any

# It only ends a hang. The Makefile sets it for all languages.
LIMIT_S = float(os.environ.get("ML2S_TEST_LIMIT_S", "120"))
# A child that was asked to end has this time before it is asked more firmly.
GRACE_S = LIMIT_S / 8


def durations_s(shortest_s: float) -> tuple[float, float, float]:
    """Returns durations to try one after another, until a run of that length has shown enough."""
    return shortest_s, 5 * shortest_s, LIMIT_S


def is_done(future: Any, timeout_s: float) -> bool:
    """Waits for a future of rclpy whose node another thread spins."""
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    return done.wait(timeout_s)


def await_true(is_true: Callable[[], bool], pause_s: float = 0.01) -> None:
    """Asks again after each pause, where nothing tells when; fails when it does not come so."""
    deadline_s = time.monotonic() + LIMIT_S
    while not is_true():
        assert time.monotonic() < deadline_s
        time.sleep(pause_s)
