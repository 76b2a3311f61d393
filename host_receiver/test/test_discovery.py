import queue
import secrets
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest
from zeroconf import Zeroconf
from zeroconf._dns import DNSPointer
from zeroconf._protocol.outgoing import DNSOutgoing

from ml2_receiver.transport import discovery
from ml2_receiver.transport.discovery import (
    SERVICE_TYPE,
    Announcement,
    FoundReceiver,
    announced_hosts,
    find_receivers,
)
from own_environment import MAY_MOUNT_AND_MAKE_NETWORKS
from repeated import repeated
from ros_processes import environment
from waiting import LIMIT_S, await_true

LOOPBACK = ["127.0.0.1"]
GROUP = ("224.0.0.251", 5353)
# The number of announcements of a new name by zeroconf; it sends the first one twice.
ANNOUNCEMENTS = 4
# An announcement takes 2.4 s; a responder says one record once a second at most.
LOOK_S = 1.2
_OWN = secrets.token_hex(3)


def own(name: str) -> str:
    """The name with what no test of another checkout on this machine announces."""
    return f"{name}-{_OWN}"


def on_the_wire(name: str) -> bytes:
    """The label of RFC 1035, 3.1."""
    return bytes([len(name)]) + name.encode()


@contextmanager
def announced(name: str, port: int, fingerprint: str | None = None) -> Iterator[Announcement]:
    announcement = Announcement(name, ("127.0.0.1", port), fingerprint, pytest.fail)
    try:
        yield announcement
    finally:
        announcement.close()


@contextmanager
def overheard() -> Iterator[queue.Queue[bytes]]:
    """Every mDNS packet on loopback, as it is on the wire."""
    packets: queue.Queue[bytes] = queue.Queue()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        listener.bind(GROUP)
        member = socket.inet_aton(GROUP[0]) + socket.inet_aton("127.0.0.1")
        listener.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        listener.settimeout(0.1)

        def listen() -> None:
            with suppress(TimeoutError):
                packets.put(listener.recv(9000))

        with repeated(listen, 0):
            yield packets


def said_of(name: str, packets: queue.Queue[bytes], until: bytes) -> bytes:
    """The packets that have a name, up to the one that has `until`, too."""
    said = b""
    while until not in said:
        packet = packets.get(timeout=LIMIT_S)
        said += packet if on_the_wire(name) in packet else b""
    return said


@contextmanager
def pointed_at(names: list[str]) -> Iterator[None]:
    """Says ten times a second that there are receivers of these names, and never where."""
    said = DNSOutgoing(0x8400)  # an authoritative answer
    for name in names:
        alias = f"{name}.{SERVICE_TYPE}"
        said.add_answer_at_time(DNSPointer(SERVICE_TYPE, 12, 1, 60, alias), 0)
    with (
        Zeroconf(interfaces=LOOPBACK) as speaker,
        repeated(lambda: speaker.send(said), 0.1),
    ):
        yield


def found(names: set[str]) -> dict[str, FoundReceiver]:
    """The receivers of these names, as soon as all are found; other tests may announce theirs."""
    receivers: dict[str, FoundReceiver] = {}
    end_s = time.monotonic() + LIMIT_S
    while receivers.keys() != names and time.monotonic() < end_s:
        receivers |= {it.name: it for it in find_receivers(LOOK_S, LOOPBACK) if it.name in names}
    assert receivers.keys() == names
    return receivers


def test_receivers_are_found_by_name_with_address_and_port() -> None:
    first, second = own("desk-a"), own("desk-b")
    with announced(first, 7001), announced(second, 7002):
        receivers = found({first, second})
    assert receivers[first] == FoundReceiver(first, ("127.0.0.1",), 7001)
    assert receivers[second].port == 7002


def test_one_search_finds_all_receivers_of_a_machine() -> None:
    both = {own("one-a"), own("one-b")}
    with announced(own("one-a"), 7011), announced(own("one-b"), 7012):
        # A machine that stands still may lose the answers to one of them
        await_true(lambda: both <= {it.name for it in find_receivers(interfaces=LOOPBACK)})


def test_names_without_an_address_are_not_found_and_leave_nothing_running() -> None:
    names = [own(f"silent-{number}") for number in range(3)]
    before = set(threading.enumerate())
    with pointed_at(names):
        speaking = set(threading.enumerate())
        assert not {it.name for it in find_receivers(0.5, LOOPBACK)} & set(names)
        assert set(threading.enumerate()) <= speaking
    assert set(threading.enumerate()) <= before


def test_names_that_dns_does_not_allow_end_no_search() -> None:
    names = ["_sub", "a\x1b]52;c;QUJD\x07", "_http._tcp"]
    with pointed_at(names), announced(own("allowed"), 7012), overheard() as packets:
        while on_the_wire("_sub") not in packets.get(timeout=LIMIT_S):
            pass
        found({own("allowed")})


def test_of_very_many_names_a_hundred_are_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[str] = []

    async def resolve(_: object, name: str, __: float) -> None:
        tried.append(name)

    monkeypatch.setattr(discovery, "_resolve", resolve)
    with pointed_at([own(f"many-{number}") for number in range(300)]):
        while len(tried) < 100:
            tried.clear()
            find_receivers(0.5, LOOPBACK)
    assert len(tried) == 100


def test_a_name_that_is_taken_gets_a_number() -> None:
    twin, other = own("twin"), own("twin") + "-2"
    with announced(twin, 7003):
        found({twin})
        with announced(twin, 7004):
            assert found({twin, other})[other].port == 7004


def test_a_name_that_has_just_been_announced_is_taken_too() -> None:
    """A responder that has just announced a record does not repeat it at once."""
    quick, other = own("quick"), own("quick") + "-2"
    with overheard() as packets, announced(quick, 7009):
        said = 0
        while said < ANNOUNCEMENTS:
            packet = packets.get(timeout=LIMIT_S)
            said += on_the_wire(quick) in packet and struct.unpack_from(">H", packet, 2)[0] >> 15
        with announced(quick, 7010):
            assert found({quick, other})[other].port == 7010


def test_one_that_is_closed_says_goodbye() -> None:
    with overheard() as packets:
        with announced(own("leaver"), 7005):
            found({own("leaver")})
        while True:
            packet = packets.get(timeout=LIMIT_S)
            record = packet.find(on_the_wire(own("leaver")), 12)
            pointer = b"_ml2sensors"
            is_goodbye = struct.pack(">I", 0) in packet and pointer in packet and record > 0
            if is_goodbye and struct.unpack_from(">H", packet, 2)[0] & 0x8000:
                return


def test_the_text_record_has_name_version_and_fingerprint_only() -> None:
    name = own("lab.pc")
    with overheard() as packets, announced(name, 7006, "ab" * 32):
        found({own("lab-pc")})
        said = said_of(own("lab-pc"), packets, until=b"version=1")
    text = on_the_wire(f"name={name}") + b"\x09version=1\x43fp=" + b"ab" * 32
    assert struct.pack(">H", len(text)) + text in said


def test_without_tls_no_fingerprint_is_announced() -> None:
    with overheard() as packets, announced(own("open"), 7008):
        found({own("open")})
        said = said_of(own("open"), packets, until=b"\x09version=1")
    assert b"fp=" not in said


@pytest.mark.parametrize(("name", "cut"), [("x" * 64, "x" * 53), ("ü" * 40, "ü" * 26)])
def test_a_long_name_is_cut_to_what_dns_takes(name: str, cut: str) -> None:
    """59 bytes, of which 6 are own."""
    with announced(_OWN + name, 7007):
        assert found({_OWN + cut})[_OWN + cut].port == 7007


MOVING = """
import subprocess, sys, time
from ml2_receiver.transport import discovery
from ml2_receiver.transport.discovery import Announcement, find_receivers

discovery._UPDATE_S = 0.2

def ip(*words):
    subprocess.run(["ip", *words], check=True)

def await_addresses(expected):
    deadline_s = time.monotonic() + float(sys.argv[1])
    while time.monotonic() < deadline_s:
        found = {it.name: it.addresses for it in find_receivers(1.2)}
        if found.get("mover") == expected:
            return
    sys.exit(f"expected {expected}, found {found}")

ip("link", "set", "lo", "up")
ip("link", "add", "lan", "type", "veth", "peer", "name", "headset")
with Announcement("mover", ("::", 7011), None, sys.exit):
    await_addresses(("127.0.0.1",))
    ip("link", "set", "lan", "up")
    ip("link", "set", "headset", "up")
    ip("addr", "add", "10.77.0.1/24", "dev", "lan")
    await_addresses(("10.77.0.1",))
    ip("addr", "del", "10.77.0.1/24", "dev", "lan")
    ip("addr", "add", "10.77.0.2/24", "dev", "lan")
    await_addresses(("10.77.0.2",))
    ip("addr", "add", "fd77::2/64", "dev", "lan", "nodad")
    await_addresses(("10.77.0.2", "fd77::2"))
    ip("addr", "del", "fd77::2/64", "dev", "lan")
    ip("addr", "del", "10.77.0.2/24", "dev", "lan")
    await_addresses(("127.0.0.1",))
"""


@pytest.mark.skipif(not MAY_MOUNT_AND_MAKE_NETWORKS, reason="only root can make a network")
def test_addresses_that_come_and_go_are_followed() -> None:
    moving = subprocess.run(
        ["unshare", "--net", sys.executable, "-c", MOVING, str(LIMIT_S)],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert moving.returncode == 0, moving.stderr


def test_what_is_announced_is_reachable() -> None:
    assert announced_hosts("127.0.0.1") == ["127.0.0.1"]
    assert announced_hosts("::1") == ["::1"]
    hosts = announced_hosts("0.0.0.0")
    assert hosts
    for host in hosts:
        with socket.create_server((host, 0)):
            pass
