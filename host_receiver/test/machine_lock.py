"""Locks of this machine, for what the tests of all its checkouts and users share."""

from __future__ import annotations

import socket


def try_lock(name: str) -> socket.socket | None:
    """Locks `name` until the result is closed or this process ends; None if it is locked."""
    # A name without a file: another user could not open the file of the first one.
    lock = socket.socket(socket.AF_UNIX)
    try:
        lock.bind(f"\0ml2_test_{name}")
    except OSError:
        lock.close()
        return None
    return lock
