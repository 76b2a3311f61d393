"""How often and how many times one address may connect."""

from collections import Counter
from collections.abc import Callable
from ipaddress import IPv6Address, ip_address

from .settings import Limits

# Addresses with failures that are kept in mind; the one that failed first is forgotten for more.
_ADDRESSES = 1024
_IPV6_SITE_BITS = 64


class Admission:
    """Counts connections, and attempts that failed to show a paired certificate, by address.

    Failures are a token bucket: a burst of them is free, then they must keep to a rate. Both are
    larger for an address that lately showed a paired certificate, as others may share it. Of
    IPv6 addresses the first 64 bits count, as one machine has all that begin so. Calls must not
    overlap.
    """

    def __init__(self, limits: Limits, clock: Callable[[], float]) -> None:
        self._limits, self._clock = limits, clock
        self._connections: Counter[str] = Counter()
        self._failures: dict[str, tuple[float, float]] = {}  # how many, as of when in s
        self._showed_s: dict[str, float] = {}

    def refusal(self, host: str) -> str | None:
        """Why it may not connect now; None when it may."""
        address, limits = _group(host), self._limits
        if self._connections[address] >= limits.connections_per_address:
            return f"it has {limits.connections_per_address} connections"
        most, _ = self._allowance(address)
        if self._failed(address) + 1 > most:
            return "too many failed attempts; it has to wait"
        return None

    def opened(self, host: str) -> None:
        self._connections[_group(host)] += 1

    def closed(self, host: str) -> None:
        address = _group(host)
        self._connections[address] -= 1
        if not self._connections[address]:
            del self._connections[address]

    def failed(self, host: str) -> None:
        """A connection has failed to show that it may have a session."""
        address = _group(host)
        failures = self._failed(address) + 1
        self._failures.pop(address, None)
        if len(self._failures) >= _ADDRESSES:
            del self._failures[next(iter(self._failures))]
        self._failures[address] = failures, self._clock()

    def showed(self, host: str) -> None:
        """A connection has shown a paired certificate."""
        address = _group(host)
        self._showed_s.pop(address, None)
        if len(self._showed_s) >= _ADDRESSES:
            del self._showed_s[next(iter(self._showed_s))]
        self._showed_s[address] = self._clock()

    def _allowance(self, address: str) -> tuple[int, float]:
        """How many failures at once, and how many per second."""
        limits, showed_s = self._limits, self._showed_s.get(address)
        if showed_s is not None and self._clock() - showed_s < limits.shared_address_s:
            return limits.shared_failed_attempts, limits.shared_failed_attempts_per_s
        return limits.failed_attempts, limits.failed_attempts_per_s

    def _failed(self, address: str) -> float:
        failures, as_of_s = self._failures.get(address, (0.0, 0.0))
        _, forgiven_per_s = self._allowance(address)
        forgiven = (self._clock() - as_of_s) * forgiven_per_s
        return max(0.0, failures - forgiven)


def _group(host: str) -> str:
    address = ip_address(host)
    if isinstance(address, IPv6Address):
        return f"{int(address) >> _IPV6_SITE_BITS:x}"
    return str(address)
