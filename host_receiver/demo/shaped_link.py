"""A link of known rate on this machine, for programs in two network namespaces. Needs root."""

import contextlib
import functools
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import delayed_link
from delayed_link import DEVICE

# The longest time that data wait in a link.
QUEUE_S = 0.05
_BURST_BYTES = 32 * 1024
_NEAR, _FAR = "10.77.0.1", "10.77.0.2"


@dataclass(frozen=True)
class Machine:
    """A machine that runs processes.

    Attributes:
        prefix: the words before each command, which run it there; empty for this one.
        address: as the other machine reaches it.
    """

    prefix: tuple[str | Path, ...] = ()
    address: str = "127.0.0.1"


@dataclass(frozen=True)
class Link:
    """Two namespaces, and the token buckets or the `forwarder` between them.

    Attributes:
        buckets: the namespaces and devices whose output has a rate.
    """

    receiver: Machine
    headset: Machine
    buckets: tuple[tuple[str, str], ...] = ()
    forwarder: subprocess.Popen[str] | None = None

    def limit(self, rate_mbit: float, queue_bytes: float | None = None) -> None:
        """Sets the rate of each bucket; it can be changed at any time.

        Args:
            queue_bytes: what waits in a bucket at most; None means what it sends in 50 ms.
        """
        queue_bytes = queue_bytes or rate_mbit * 1e6 / 8 * QUEUE_S
        for namespace, device in self.buckets:
            _run(
                *(*_inside(namespace), "tc", "qdisc", "replace", "dev", device, "root", "tbf"),
                *("rate", f"{rate_mbit}mbit", "burst", str(_BURST_BYTES)),
                *("limit", str(int(queue_bytes) + _BURST_BYTES)),
            )
        # A token bucket takes up a new rate only with the next packet; TCP may wait a second for it
        _run(*self.headset.prefix, "bash", "-c", f"echo > /dev/udp/{self.receiver.address}/9")

    def dropped(self) -> int:
        """Returns how many packets the queues have dropped; ends a forwarder."""
        if self.forwarder is not None:
            self.forwarder.terminate()
            return int(self.forwarder.communicate()[0])
        return sum(self._counts("drops"))

    def sent_bytes(self) -> list[int]:
        """Returns how much each bucket has sent, with all headers."""
        return self._counts("bytes")

    def _counts(self, name: str) -> list[int]:
        show = ("tc", "-j", "-s", "qdisc", "show", "dev")
        shown = (json.loads(_run(*_inside(it), *show, device)) for it, device in self.buckets)
        return [int(root[name]) for root, *_ in shown]


@contextlib.contextmanager
def link(
    congestion: str,
    rate_mbit: float,
    rtt_ms: float = 0.0,
    way_back: Literal["free", "own", "shared"] = "free",
) -> Iterator[Link]:
    """Makes a link whose TCP connections use this congestion control.

    Args:
        way_back: what the receiver sends has no rate, the same rate of its own, or shares the rate
            with what the headset sends, as in the air of Wi-Fi; the last two without a round trip.
    """
    assert not rtt_ms or way_back == "free", "a link with a round trip has no rate for the way back"
    near, far, air = (f"ml2{it}{os.getpid()}" for it in "rha")
    hosts = Machine(_inside(near), _NEAR), Machine(_inside(far), _FAR)
    with contextlib.ExitStack() as stack:
        for name in (near, far, air) if way_back == "shared" else (near, far):
            _run("ip", "netns", "add", name)
            stack.callback(_run, "ip", "netns", "delete", name)
            _run("ip", "-n", name, "link", "set", "lo", "up")
        forwarder, buckets = None, [(far, DEVICE)]
        if rtt_ms:
            rates = (str(rate_mbit), str(rtt_ms / 2), str(QUEUE_S * 1e3))
            forwarder, buckets = stack.enter_context(_forwarder(near, far, *rates)), []
        elif way_back == "shared":
            for name in (near, far):
                _veth(name, DEVICE, air, name)
            buckets = [(air, _share(air, {near: _NEAR, far: _FAR}))]
        else:
            _veth(near, DEVICE, far, DEVICE)
            if way_back == "own":
                buckets.append((near, DEVICE))
        for name, host in zip((near, far), hosts, strict=True):
            _run("ip", "-n", name, "address", "add", f"{host.address}/30", "dev", DEVICE)
            mtu = ("mtu", str(delayed_link.MTU)) if rtt_ms else ()
            _run("ip", "-n", name, "link", "set", DEVICE, *mtu, "up")
            route = ("10.77.0.0/30", "dev", DEVICE, "src", host.address, "congctl", congestion)
            _run("ip", "-n", name, "route", "replace", *route)
        made = Link(*hosts, tuple(buckets), forwarder)
        if buckets:
            made.limit(rate_mbit)
        yield made


def _veth(namespace: str, device: str, other: str, device_there: str) -> None:
    both = (namespace, "type", "veth", "peer", device_there, "netns", other)
    _run("ip", "link", "add", device, "netns", *both)


def _share(namespace: str, addresses: Mapping[str, str]) -> str:
    """Forwards between the devices of a namespace; returns the one whose output all packets are.

    They come back through its peer, and are then routed to their address.

    Args:
        addresses: by device, those of the machines that the devices lead to.
    """
    out, back = "out", "back"
    run = functools.partial(_run, *_inside(namespace))

    def set_ipv4(parameter: str, value: int) -> None:
        run("bash", "-c", f"echo {value} > /proc/sys/net/ipv4/{parameter}")

    _veth(namespace, out, namespace, back)
    set_ipv4("ip_forward", 1)
    for device in ("all", out, back, *addresses):
        set_ipv4(f"conf/{device}/rp_filter", 0)
    for device in (out, back, *addresses):
        run("ip", "link", "set", device, "up")
    (peer,) = json.loads(run("ip", "-j", "link", "show", back))
    run("ip", "address", "add", "10.77.9.1/30", "dev", out)
    run("ip", "neigh", "add", "10.77.9.2", "lladdr", peer["address"], "dev", out)
    run("ip", "route", "add", "default", "via", "10.77.9.2", "table", "100")
    for device, address in addresses.items():
        set_ipv4(f"conf/{device}/proxy_arp", 1)
        run("ip", "route", "add", address, "dev", device)
        run("ip", "rule", "add", "iif", device, "lookup", "100")
    return out


@contextlib.contextmanager
def _forwarder(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    command = (sys.executable, delayed_link.__file__, *arguments)
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as forwarder:
        try:
            assert forwarder.stdout is not None
            if forwarder.stdout.readline() != "ready\n":
                raise OSError("there are no TUN devices")
            yield forwarder
        finally:
            forwarder.kill()


def _inside(namespace: str) -> tuple[str, ...]:
    return "ip", "netns", "exec", namespace


def _run(*command: str | Path) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def why_not() -> str | None:
    """Returns why this machine can make no links, or None if it can."""
    if os.geteuid() != 0:
        return "only root may make network namespaces"
    try:
        with link("cubic", 100):
            pass
    except (OSError, subprocess.CalledProcessError) as error:
        return f"this machine makes no links: {error}"
    return None
