"""TCP ports for tests that must know one before anybody listens, and locks of this machine.

The tests of all its checkouts and users share both.
"""

import random
import socket
from collections import deque

# Linux gives those from 32768 on to connections, at any time.
_PORTS = range(20_000, 32_768)
# Many more than a test needs.
_KEPT = 20
_reserved: deque[socket.socket] = deque()


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


def reserve_port() -> int:
    """A port of this machine that no other test has until this process has reserved 20 more."""
    for port in random.sample(_PORTS, len(_PORTS)):
        lock = try_lock(f"port_{port}")
        if lock is None:
            continue
        if _is_free(port):
            _reserved.append(lock)
            if len(_reserved) > _KEPT:
                _reserved.popleft().close()
            return port
        lock.close()
    raise RuntimeError("every port is in use")


def _is_free(port: int) -> bool:
    try:
        socket.create_server(("127.0.0.1", port)).close()
    except OSError:
        return False
    return True
