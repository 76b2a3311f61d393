"""Limits the connections and the failed attempts of each address."""

from collections import Counter
from collections.abc import Callable
from ipaddress import IPv6Address, ip_address

from .settings import Limits

# The most addresses that are stored; a further one replaces the oldest.
_ADDRESSES = 1024
_IPV6_SITE_BITS = 64


class AddressLimits:
    """The connections and failed attempts of each address.

    An attempt fails if the peer shows no paired certificate. A token bucket limits failures to a
    burst and then to a rate. Both are larger for an address that showed a paired certificate
    lately, as other peers may share that address. IPv6 addresses with the same first 64 bits count
    as one, as one machine can use them all. Calls must not overlap.
    """

    def __init__(self, limits: Limits, clock: Callable[[], float]) -> None:
        self._limits, self._clock = limits, clock
        self._connections: Counter[str] = Counter()
        self._failures: dict[str, tuple[float, float]] = {}  # count, time in s
        self._showed_s: dict[str, float] = {}

    def refusal(self, host: str) -> str | None:
        """Returns why the address may not connect now, or None if it may."""
        address, limits = _group(host), self._limits
        if self._connections[address] >= limits.connections_per_address:
            return f"it has {limits.connections_per_address} connections"
        burst, _ = self._allowance(address)
        if self._current_failures(address) + 1 > burst:
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
        """Counts a connection that showed no paired certificate."""
        address = _group(host)
        failures = self._current_failures(address) + 1
        self._failures.pop(address, None)
        if len(self._failures) >= _ADDRESSES:
            del self._failures[next(iter(self._failures))]
        self._failures[address] = failures, self._clock()

    def showed(self, host: str) -> None:
        """Notes that a connection showed a paired certificate."""
        address = _group(host)
        self._showed_s.pop(address, None)
        if len(self._showed_s) >= _ADDRESSES:
            del self._showed_s[next(iter(self._showed_s))]
        self._showed_s[address] = self._clock()

    def _allowance(self, address: str) -> tuple[int, float]:
        """Returns the allowed burst of failures, and their rate in 1/s."""
        limits, showed_s = self._limits, self._showed_s.get(address)
        if showed_s is not None and self._clock() - showed_s < limits.shared_address_s:
            return limits.shared_failed_attempts, limits.shared_failed_attempts_per_s
        return limits.failed_attempts, limits.failed_attempts_per_s

    def _current_failures(self, address: str) -> float:
        failures, counted_s = self._failures.get(address, (0.0, 0.0))
        _, forgiven_per_s = self._allowance(address)
        forgiven = (self._clock() - counted_s) * forgiven_per_s
        return max(0.0, failures - forgiven)


def _group(host: str) -> str:
    """Returns the key under which an address is counted."""
    address = ip_address(host)
    if isinstance(address, IPv6Address):
        return f"{int(address) >> _IPV6_SITE_BITS:x}"
    return str(address)
