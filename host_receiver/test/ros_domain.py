"""ROS domains that nobody else on this machine uses."""

import random
import socket
from collections import deque

from free_port import try_lock

# From 102 on, ports of domains may be those that Linux gives to connections.
_DOMAINS = range(1, 102)
# A receiver has three, with its processes of large messages.
_PARTICIPANTS = 10
# Many enough that who was killed in one is out of its graph by the time it is given back.
_KEPT = 10
_reserved: deque[socket.socket] = deque()


def reserve_domain() -> int:
    """A silent domain that no other test has until this process ends or has reserved ten more."""
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        lock = try_lock(f"domain_{domain}")
        if lock is None:
            continue
        _reserved.append(lock)
        if len(_reserved) > _KEPT:
            _reserved.popleft().close()
        if _is_silent(domain):
            return domain
    raise RuntimeError("every ROS domain is in use")


def _is_silent(domain: int) -> bool:
    """Returns True if nobody uses a port of a domain's first participants (DDSI-RTPS 2.5, 9.6.2.3).

    Processes of a test that has ended may still be there.
    """
    for participant in range(_PARTICIPANTS):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * domain + 10 + 2 * participant))
            except OSError:
                return False
    return True
