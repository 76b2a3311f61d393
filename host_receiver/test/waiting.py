"""How long tests wait for what has to come, on however slow a machine."""

import time
from collections.abc import Callable

LIMIT_S = 40.0
# How long a child that was asked to end may take until it is asked more firmly.
GRACE_S = 5.0


def await_true(is_true: Callable[[], bool]) -> None:
    """Asks again and again, where nothing tells when; fails when it does not come so."""
    deadline_s = time.monotonic() + LIMIT_S
    while not is_true():
        assert time.monotonic() < deadline_s
        time.sleep(0.01)
