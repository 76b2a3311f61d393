"""TCP ports for tests that must know one before anybody listens there."""

from __future__ import annotations

import random
import socket

from machine_lock import try_lock

# Linux gives those from 32768 on to connections, at any time.
_PORTS = range(20_000, 32_768)
_reserved: list[socket.socket] = []


def reserve_port() -> int:
    """A port of this machine that no other test has until this process ends."""
    for port in random.sample(_PORTS, len(_PORTS)):
        lock = try_lock(f"port_{port}")
        if lock is None:
            continue
        if _is_free(port):
            _reserved.append(lock)
            return port
        lock.close()
    raise RuntimeError("every port is in use")


def _is_free(port: int) -> bool:
    try:
        socket.create_server(("127.0.0.1", port)).close()
    except OSError:
        return False
    return True
