"""Announces and finds receivers by name, with DNS-SD (RFC 6763) over mDNS (RFC 6762)."""

import asyncio
import uuid
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from ipaddress import IPv4Address, IPv6Address, ip_address
from pathlib import Path
from typing import Self

import ifaddr
from zeroconf import (
    BadTypeInNameException,
    DNSQuestionType,
    IPVersion,
    ServiceInfo,
    ServiceStateChange,
    Zeroconf,
)
from zeroconf.asyncio import AsyncServiceBrowser, AsyncServiceInfo

from ..errors import DiscoveryError
from ..wire.frame import VERSION

type Address = IPv4Address | IPv6Address

SERVICE_TYPE = "_ml2sensors._tcp.local."
# Long enough that a receiver that has just answered another search answers again.
SEARCH_S = 3.0
_QUIET_S = 1.2
# The interval at which changed addresses are announced.
_UPDATE_S = 2.0
# Anybody can announce names, as many as they like.
_MOST_FOUND = 100

_LOOPBACK = "127.0.0.1"
# The limit of RFC 1035, less the number that distinguishes receivers of the same name.
_MAX_NAME_BYTES = 63 - len("-999")
_INTERFACES = Path("/sys/class/net")


class Announcement:
    """The announcement of a receiver until close(); also a context manager.

    A receiver that listens on loopback is announced only there. Multicast uses IPv4. Changes of the
    machine's addresses are announced within 2 s. In the first 2.4 s the receiver cannot be found,
    as the network is asked whether its name is free.

    Args:
        name: the receiver's name; a number is appended if the name is taken.
        address: the address that the receiver listens on, from socket.getsockname().
        fingerprint: the fingerprint of the receiver's certificate; None without TLS.
        failed: called with the reason if the announcement fails, at once or by another thread.
    """

    def __init__(
        self,
        name: str,
        address: tuple[str, int],
        fingerprint: str | None,
        failed: Callable[[str], None],
    ) -> None:
        host, port = address[:2]
        label = _label(name)
        info = ServiceInfo(
            SERVICE_TYPE,
            f"{label}.{SERVICE_TYPE}",
            port=port,
            properties=_properties(name, fingerprint),
            # Unique, as the records of a host name are replaced as a whole (RFC 6762, 10.2).
            server=f"{uuid.uuid4().hex}.local.",
            parsed_addresses=announced_hosts(host),
        )
        self._zeroconf: Zeroconf | None = None
        self._announcing: asyncio.Task[None] | None = None
        try:
            self._zeroconf = Zeroconf(interfaces=_multicast_interfaces(ip_address(host)))
        except OSError as error:
            failed(str(error))
            return
        self._call(self._announce(info, ip_address(host))).add_done_callback(
            partial(_report_failure, failed)
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Withdraws the announcement; further calls do nothing."""
        if self._zeroconf is not None:
            self._call(self._end_announcing()).result()
            self._zeroconf.close()
            self._zeroconf = None

    def _call(self, work: Coroutine[None, None, None]) -> Future[None]:
        assert self._zeroconf is not None
        assert self._zeroconf.loop is not None
        return asyncio.run_coroutine_threadsafe(work, self._zeroconf.loop)

    async def _announce(self, info: ServiceInfo, listening: Address) -> None:
        assert self._zeroconf is not None
        self._announcing = asyncio.current_task()
        await _register(self._zeroconf, info)
        await _announce_changes(self._zeroconf, info, listening)

    async def _end_announcing(self) -> None:
        """Cancels the announcing task, which Zeroconf.close() would leave behind with a warning."""
        if self._announcing is not None:
            self._announcing.cancel()
            await asyncio.wait([self._announcing])


async def _register(zeroconf: Zeroconf, info: ServiceInfo) -> None:
    # The answer to a probe goes to the one port that all programs of a machine share, so this
    # program may not see it. Answers to this browser's questions are multicast.
    browser = AsyncServiceBrowser(
        zeroconf, SERVICE_TYPE, [lambda **_: None], question_type=DNSQuestionType.QM
    )
    try:
        # A responder that announced a name within the last second does not answer (RFC 6762, 6).
        await asyncio.sleep(_QUIET_S)
        await (await zeroconf.async_register_service(info, allow_name_change=True, strict=False))
    finally:
        await browser.async_cancel()


async def _announce_changes(zeroconf: Zeroconf, info: ServiceInfo, listening: Address) -> None:
    """Announces changes of addresses and interfaces until cancelled."""
    interfaces: list[str] = []
    while True:
        with suppress(OSError):  # an address has just disappeared; the next round tries again
            if (present := _multicast_interfaces(listening)) != interfaces:
                await zeroconf.async_update_interfaces(present)
                interfaces = present
            packed = [ip_address(it).packed for it in announced_hosts(str(listening))]
            if packed != info.addresses_by_version(IPVersion.All):
                info.addresses = packed
                await zeroconf.async_update_service(info)
        await asyncio.sleep(_UPDATE_S)


def _report_failure(failed: Callable[[str], None], registering: Future[None]) -> None:
    if not registering.cancelled() and (error := registering.exception()) is not None:
        failed(str(error) or type(error).__name__)


def _properties(name: str, fingerprint: str | None) -> dict[str, str]:
    properties = {"name": name, "version": str(VERSION)}
    return properties if fingerprint is None else properties | {"fp": fingerprint}


def _label(name: str) -> str:
    """Returns `name` as one DNS label."""
    return name.replace(".", "-").encode()[:_MAX_NAME_BYTES].decode(errors="ignore")


def announced_hosts(host: str) -> list[str]:
    """Returns the hosts at which a receiver that listens on `host` can be reached.

    For a wildcard these are the machine's addresses, IPv4 first; `::` includes IPv4. Addresses of
    bridges and tunnels are left out if there are others, as other machines seldom reach them.
    """
    listening = ip_address(host)
    if not listening.is_unspecified:
        return [host]
    reachable = [
        (adapter, address)
        for adapter, address in _addresses()
        if address.version <= listening.version
        and not (address.is_loopback or address.is_link_local)
    ]
    reachable.sort(key=lambda it: it[1].version)
    physical = [(adapter, it) for adapter, it in reachable if _is_physical(adapter)]
    return [str(address) for _, address in physical or reachable] or [_LOOPBACK]


def _addresses() -> Iterator[tuple[str, Address]]:
    """Yields the name of every interface with each of its addresses."""
    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            yield adapter.name, ip_address(ip.ip if isinstance(ip.ip, str) else ip.ip[0])


def _is_physical(adapter: str) -> bool:
    return (_INTERFACES / adapter / "device").exists()


def _multicast_interfaces(listening: Address) -> list[str]:
    """Returns the IPv4 addresses of the interfaces that have `listening`, and loopback."""
    adapters = {
        name for name, address in _addresses() if listening.is_unspecified or address == listening
    }
    reached = [str(it) for name, it in _addresses() if name in adapters and it.version == 4]
    return list(dict.fromkeys([*reached, _LOOPBACK]))


@dataclass(frozen=True)
class FoundReceiver:
    """An announced receiver; `addresses` are its hosts, the most reliable first."""

    name: str
    addresses: tuple[str, ...]
    port: int


def find_receivers(
    timeout_s: float = SEARCH_S, interfaces: list[str] | None = None
) -> list[FoundReceiver]:
    """Returns the receivers that are found within `timeout_s`, at most 100, sorted by name.

    A responder repeats a record at most once a second (RFC 6762, 6), so a search right after
    another one must take longer than 1 s.

    Args:
        interfaces: the IPv4 addresses of the interfaces to search on; None means all.

    Raises:
        DiscoveryError: multicast is not available.
    """
    every = _multicast_interfaces(IPv4Address(0))
    try:
        with Zeroconf(interfaces=interfaces or every) as zeroconf:
            assert zeroconf.loop is not None
            search = asyncio.run_coroutine_threadsafe(_search(zeroconf, timeout_s), zeroconf.loop)
            try:
                return search.result()
            finally:  # by Ctrl-C, too
                search.cancel()
    except OSError as error:
        raise DiscoveryError(f"no multicast: {error.strerror}") from error


async def _search(zeroconf: Zeroconf, timeout_s: float) -> list[FoundReceiver]:
    resolving: dict[str, asyncio.Task[FoundReceiver | None]] = {}

    def changed(
        zeroconf: Zeroconf, service_type: str, name: str, state_change: ServiceStateChange
    ) -> None:
        if name in resolving:
            resolving.pop(name).cancel()
        if state_change is not ServiceStateChange.Removed and len(resolving) < _MOST_FOUND:
            resolving[name] = asyncio.ensure_future(_resolve(zeroconf, name, timeout_s))

    question = DNSQuestionType.QM
    try:
        async with AsyncServiceBrowser(zeroconf, SERVICE_TYPE, [changed], question_type=question):
            await asyncio.sleep(timeout_s)
    finally:
        done = [task for task in resolving.values() if task.done()]
        for task in resolving.values():
            task.cancel()
    found = [receiver for task in done if (receiver := task.result()) is not None]
    return sorted(found, key=lambda receiver: receiver.name)


async def _resolve(zeroconf: Zeroconf, name: str, timeout_s: float) -> FoundReceiver | None:
    """Returns the receiver with a service name, or None if it does not answer in time."""
    try:
        info = AsyncServiceInfo(SERVICE_TYPE, name)
    except BadTypeInNameException:
        return None
    is_whole = await info.async_request(zeroconf, timeout_s * 1000, DNSQuestionType.QM)
    if not is_whole or not info.port:
        return None
    label = name.removesuffix(f".{SERVICE_TYPE}")
    return FoundReceiver(label, tuple(info.parsed_addresses()), info.port)
