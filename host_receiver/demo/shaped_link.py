"""A link of known rate on this machine, for programs in two network namespaces. Needs root."""

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import delayed_link

# The longest time that data wait in a link.
QUEUE_S = 0.05
_BURST_BYTES = 32 * 1024


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
    """Two namespaces, and the token bucket or the `forwarder` between them."""

    receiver: Machine
    headset: Machine
    device: str
    forwarder: subprocess.Popen[str] | None = None

    def limit(self, rate_mbit: float, queue_bytes: float | None = None) -> None:
        """Sets the rate of what the headset sends; it can be changed at any time.

        Args:
            queue_bytes: what waits in the link at most; None means what it sends in 50 ms.
        """
        queue_bytes = queue_bytes or rate_mbit * 1e6 / 8 * QUEUE_S
        _run(
            *(*self.headset.prefix, "tc", "qdisc", "replace", "dev", self.device, "root", "tbf"),
            *("rate", f"{rate_mbit}mbit", "burst", str(_BURST_BYTES)),
            *("limit", str(int(queue_bytes) + _BURST_BYTES)),
        )
        # A token bucket takes up a new rate only with the next packet; TCP may wait a second for it
        _run(*self.headset.prefix, "bash", "-c", f"echo > /dev/udp/{self.receiver.address}/9")

    def dropped(self) -> int:
        """Returns how many packets the queue has dropped; ends a forwarder."""
        if self.forwarder is not None:
            self.forwarder.terminate()
            return int(self.forwarder.communicate()[0])
        show = ("tc", "-j", "-s", "qdisc", "show", "dev", self.device)
        (root, *_) = json.loads(_run(*self.headset.prefix, *show))
        return int(root["drops"])


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
            with what the headset sends, as in the air of Wi-Fi; only with a round trip.
    """
    assert rtt_ms or way_back == "free", "a link with a way back has a round trip"
    near, far = f"ml2r{os.getpid()}", f"ml2h{os.getpid()}"
    devices = (delayed_link.DEVICE,) * 2 if rtt_ms else (near, far)
    execute = ("ip", "netns", "exec")
    hosts = (Machine((*execute, near), "10.77.0.1"), Machine((*execute, far), "10.77.0.2"))
    with contextlib.ExitStack() as stack:
        for name in (near, far):
            _run("ip", "netns", "add", name)
            stack.callback(_run, "ip", "netns", "delete", name)
            _run("ip", "-n", name, "link", "set", "lo", "up")
        forwarder = None
        if rtt_ms:
            rates = (str(rate_mbit), str(rtt_ms / 2), str(QUEUE_S * 1e3), way_back)
            forwarder = stack.enter_context(_forwarder(near, far, *rates))
        else:
            _run("ip", "link", "add", far, "netns", far, "type", "veth", "peer", near)
            _run("ip", "link", "set", near, "netns", near)
        for name, device, host in zip((near, far), devices, hosts, strict=True):
            _run("ip", "-n", name, "address", "add", f"{host.address}/30", "dev", device)
            mtu = ("mtu", str(delayed_link.MTU)) if rtt_ms else ()
            _run("ip", "-n", name, "link", "set", device, *mtu, "up")
            route = ("10.77.0.0/30", "dev", device, "src", host.address, "congctl", congestion)
            _run("ip", "-n", name, "route", "replace", *route)
        made = Link(*hosts, devices[1], forwarder)
        if forwarder is None:
            made.limit(rate_mbit)
        yield made


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
