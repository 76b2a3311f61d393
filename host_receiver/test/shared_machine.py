"""Tests of all checkouts and users of this machine take turns, so that it carries them."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Generator, Sequence
from pathlib import Path

import pytest

from machine_lock import try_lock

# The tests of one checkout, of which a few run at a time on two processors, never wait.
_PLACES = 3 * (os.cpu_count() or 1)
_POLL_S = 0.05


def in_turns(folder: Path, places: int) -> Callable[[pytest.Item], Generator[None, object, object]]:
    """Returns the hook of a `conftest.py` that runs each test when the machine has room for it.

    Args:
        folder: of that `conftest.py`. pytest calls the hook for tests of other folders, too, and
            who waits for places while he has some may wait for himself.
        places: of the machine that a test takes, of three a processor. One that is marked as
            alone takes all.
    """

    @pytest.hookimpl(wrapper=True, tryfirst=True)  # the time limit begins after the waiting
    def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
        if not item.path.is_relative_to(folder):
            return (yield)
        taken = _take(_PLACES if item.get_closest_marker("alone") else min(places, _PLACES))
        try:
            return (yield)
        finally:
            for place in taken:
                place.close()

    return pytest_runtest_protocol


def _take(count: int) -> list[socket.socket]:
    # One waits in front and the others behind it, or who needs many places would never get them.
    front = _await_lock(["front"])
    places = [f"place_{number}" for number in range(_PLACES)]
    taken = [_await_lock(places) for _ in range(count)]
    front.close()
    return taken


def _await_lock(names: Sequence[str]) -> socket.socket:
    """Locks the first of `names` that nobody has."""
    while True:
        for name in names:
            lock = try_lock(name)
            if lock is not None:
                return lock
        time.sleep(_POLL_S)
