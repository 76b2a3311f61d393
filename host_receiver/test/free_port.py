"""TCP ports for tests that must know one before anybody listens there."""

from __future__ import annotations

import random
import socket

# Linux gives those from 32768 on to connections, at any time.
_PORTS = range(20_000, 32_768)
_reserved: list[socket.socket] = []


def reserve_port() -> int:
    """A port of this machine that no other test has until this process ends."""
    for port in random.sample(_PORTS, len(_PORTS)):
        # A name without a file: another user could not open the file of the first one.
        lock = socket.socket(socket.AF_UNIX)
        try:
            lock.bind(f"\0ml2_test_port_{port}")
            socket.create_server(("127.0.0.1", port)).close()
        except OSError:
            lock.close()
            continue
        _reserved.append(lock)
        return port
    raise RuntimeError("every port is in use")
