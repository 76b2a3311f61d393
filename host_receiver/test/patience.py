"""How long tests wait for what has to come, on however slow a machine."""

import time
from collections.abc import Callable

PATIENCE_S = 20.0


def await_so(is_so: Callable[[], bool]) -> None:
    """Asks again and again, where nothing tells when; fails when it does not come so."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < deadline_s
        time.sleep(0.01)
