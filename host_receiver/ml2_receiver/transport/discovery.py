"""Receivers are announced and found by name: DNS-SD (RFC 6763) over mDNS (RFC 6762)."""

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
# Long enough for a second answer of those who have just answered somebody else.
SEARCH_S = 3.0
_QUIET_S = 1.2
# How long a new address may stay unknown to headsets.
_FOLLOW_S = 2.0

_LOOPBACK = "127.0.0.1"
# RFC 1035, less the number that tells a second receiver of the same name from the first.
_MAX_NAME_BYTES = 63 - len("-999")
_INTERFACES = Path("/sys/class/net")


class Announcement:
    """Announces a receiver until close(), or as a context manager.

    One that listens on loopback is announced there only. Multicast goes over IPv4. Addresses that
    the machine gets or loses meanwhile are followed, within 2 s. For the first
    2.4 s others are asked whether the name is free, and nobody finds it.

    Args:
        name: tells receivers apart; where it is taken, a number is appended.
        address: what is listened on, as socket.getsockname() has it.
        fingerprint: by which paired devices know it; None without TLS.
        failed: is told why nobody finds it, at once or by another thread.
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
            # Of this receiver only: a host name's records are replaced as a whole (RFC 6762, 10.2).
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
        self._call(self._announce(info, ip_address(host))).add_done_callback(partial(_tell, failed))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Says that the receiver is gone; once is enough."""
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
        await _follow(self._zeroconf, info, listening)

    async def _end_announcing(self) -> None:
        """Zeroconf.close() would leave it behind, with a warning to the user."""
        if self._announcing is not None:
            self._announcing.cancel()
            await asyncio.wait([self._announcing])


async def _register(zeroconf: Zeroconf, info: ServiceInfo) -> None:
    # A probe is answered to the port that all programs of a machine share, so that none may see
    # the answer; what this browser asks is answered to all.
    browser = AsyncServiceBrowser(
        zeroconf, SERVICE_TYPE, [lambda **_: None], question_type=DNSQuestionType.QM
    )
    try:
        # Who has announced a name within the last second answers nobody (RFC 6762, 6).
        await asyncio.sleep(_QUIET_S)
        await (await zeroconf.async_register_service(info, allow_name_change=True, strict=False))
    finally:
        await browser.async_cancel()


async def _follow(zeroconf: Zeroconf, info: ServiceInfo, listening: Address) -> None:
    """Announces the addresses there are, on the interfaces there are, until cancelled."""
    interfaces: list[str] = []
    while True:
        with suppress(OSError):  # of an address that has just gone: next time
            if (present := _multicast_interfaces(listening)) != interfaces:
                await zeroconf.async_update_interfaces(present)
                interfaces = present
            packed = [ip_address(it).packed for it in announced_hosts(str(listening))]
            if packed != info.addresses_by_version(IPVersion.All):
                info.addresses = packed
                await zeroconf.async_update_service(info)
        await asyncio.sleep(_FOLLOW_S)


def _tell(failed: Callable[[str], None], registering: Future[None]) -> None:
    if not registering.cancelled() and (error := registering.exception()) is not None:
        failed(str(error) or type(error).__name__)


def _properties(name: str, fingerprint: str | None) -> dict[str, str]:
    known = {"name": name, "version": str(VERSION)}
    return known if fingerprint is None else known | {"fp": fingerprint}


def _label(name: str) -> str:
    """`name` as one DNS label."""
    return name.replace(".", "-").encode()[:_MAX_NAME_BYTES].decode(errors="ignore")


def announced_hosts(host: str) -> list[str]:
    """Where a receiver that listens on `host` is reached.

    For a wildcard these are the machine's addresses, IPv4 first, without those of bridges and
    tunnels, which others seldom reach, unless there are no others. `::` takes IPv4, too.
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
    """The name of every interface with each of its addresses."""
    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            yield adapter.name, ip_address(ip.ip if isinstance(ip.ip, str) else ip.ip[0])


def _is_physical(adapter: str) -> bool:
    return (_INTERFACES / adapter / "device").exists()


def _multicast_interfaces(listening: Address) -> list[str]:
    """The IPv4 addresses of the interfaces on which `listening` is reached, and loopback."""
    adapters = {
        name for name, address in _addresses() if listening.is_unspecified or address == listening
    }
    reached = [str(it) for name, it in _addresses() if name in adapters and it.version == 4]
    return list(dict.fromkeys([*reached, _LOOPBACK]))


@dataclass(frozen=True)
class FoundReceiver:
    """An announced receiver; `addresses` are its hosts, the surest first."""

    name: str
    addresses: tuple[str, ...]
    port: int


def find_receivers(
    timeout_s: float = SEARCH_S, interfaces: list[str] | None = None
) -> list[FoundReceiver]:
    """Listens for `timeout_s` for receivers, by name; on all interfaces unless some are given.

    A responder says one record once a second at most (RFC 6762, 6), so a search right after
    another needs more than that second.

    Raises:
        DiscoveryError: there is no multicast.
    """
    every = _multicast_interfaces(IPv4Address(0))
    try:
        with Zeroconf(interfaces=interfaces or every) as zeroconf:
            assert zeroconf.loop is not None
            search = _search(zeroconf, timeout_s)
            return asyncio.run_coroutine_threadsafe(search, zeroconf.loop).result()
    except OSError as error:
        raise DiscoveryError(f"no multicast: {error.strerror}") from error


async def _search(zeroconf: Zeroconf, timeout_s: float) -> list[FoundReceiver]:
    resolving: dict[str, asyncio.Task[FoundReceiver | None]] = {}

    def changed(
        zeroconf: Zeroconf, service_type: str, name: str, state_change: ServiceStateChange
    ) -> None:
        if name in resolving:
            resolving.pop(name).cancel()
        if state_change is not ServiceStateChange.Removed:
            resolving[name] = asyncio.ensure_future(_resolve(zeroconf, name, timeout_s))

    browser = AsyncServiceBrowser(
        zeroconf, SERVICE_TYPE, [changed], question_type=DNSQuestionType.QM
    )
    await asyncio.sleep(timeout_s)
    await browser.async_cancel()
    done = [task for task in resolving.values() if task.done()]
    for task in resolving.values():
        task.cancel()
    found = [receiver for task in done if (receiver := task.result()) is not None]
    return sorted(found, key=lambda receiver: receiver.name)


async def _resolve(zeroconf: Zeroconf, name: str, timeout_s: float) -> FoundReceiver | None:
    """Asks until it is answered; the others are resolved meanwhile."""
    info = AsyncServiceInfo(SERVICE_TYPE, name)
    is_whole = await info.async_request(zeroconf, timeout_s * 1000, DNSQuestionType.QM)
    if not is_whole or not info.port:
        return None
    label = name.removesuffix(f".{SERVICE_TYPE}")
    return FoundReceiver(label, tuple(info.parsed_addresses()), info.port)
