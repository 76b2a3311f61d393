import os
import queue
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

from ml2_receiver.transport.discovery import (
    SERVICE_TYPE,
    Announcement,
    FoundReceiver,
    announced_hosts,
    find_receivers,
)
from repeated import repeated
from ros_processes import environment

LOOPBACK = ["127.0.0.1"]
GROUP = ("224.0.0.251", 5353)
# How often zeroconf says what is new; the first time twice.
ANNOUNCEMENTS = 4
# An announcement takes 2.4 s; a responder says one record once a second at most.
LOOK_S = 1.2
LIMIT_S = 30.0


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
    with announced("desk-a", 7001), announced("desk-b", 7002):
        receivers = found({"desk-a", "desk-b"})
    assert receivers["desk-a"] == FoundReceiver("desk-a", ("127.0.0.1",), 7001)
    assert receivers["desk-b"].port == 7002


def test_one_search_finds_all_receivers_of_a_machine() -> None:
    with announced("one-a", 7011), announced("one-b", 7012):
        found({"one-a", "one-b"})
        names = {it.name for it in find_receivers(interfaces=LOOPBACK)}
    assert {"one-a", "one-b"} <= names


def test_names_without_an_address_are_not_found_and_leave_nothing_running() -> None:
    names = [f"silent-{number}" for number in range(3)]
    before = set(threading.enumerate())
    with pointed_at(names):
        speaking = set(threading.enumerate())
        assert not {it.name for it in find_receivers(0.5, LOOPBACK)} & set(names)
        assert set(threading.enumerate()) <= speaking
    assert set(threading.enumerate()) <= before


def test_a_name_that_is_taken_gets_a_number() -> None:
    with announced("twin", 7003):
        found({"twin"})
        with announced("twin", 7004):
            assert found({"twin", "twin-2"})["twin-2"].port == 7004


def test_a_name_that_has_just_been_announced_is_taken_too() -> None:
    """Those that have just said it do not say it again at once."""
    with overheard() as packets, announced("quick", 7009):
        said = 0
        while said < ANNOUNCEMENTS:
            packet = packets.get(timeout=10)
            said += b"\x05quick" in packet and struct.unpack_from(">H", packet, 2)[0] >> 15
        with announced("quick", 7010):
            assert found({"quick", "quick-2"})["quick-2"].port == 7010


def test_one_that_is_closed_says_goodbye() -> None:
    with overheard() as packets:
        with announced("leaver", 7005):
            found({"leaver"})
        while True:
            packet = packets.get(timeout=10)
            record = packet.find(b"\x06leaver", 12)
            pointer = b"_ml2sensors"
            is_goodbye = struct.pack(">I", 0) in packet and pointer in packet and record > 0
            if is_goodbye and struct.unpack_from(">H", packet, 2)[0] & 0x8000:
                return


def test_the_text_record_has_name_version_and_fingerprint_only() -> None:
    with overheard() as packets, announced("lab.pc", 7006, "ab" * 32):
        found({"lab-pc"})
        said = b"".join(packets.queue)
    text = b"\x0bname=lab.pc\x09version=1\x43fp=" + b"ab" * 32
    assert struct.pack(">H", len(text)) + text in said


def test_without_tls_no_fingerprint_is_announced() -> None:
    with overheard() as packets, announced("open", 7008):
        found({"open"})
        said = b"".join(packet for packet in packets.queue if b"\x04open" in packet)
    assert b"\x09version=1" in said
    assert b"fp=" not in said


@pytest.mark.parametrize(("name", "cut"), [("x" * 64, "x" * 59), ("ü" * 40, "ü" * 29)])
def test_a_long_name_is_cut_to_what_dns_takes(name: str, cut: str) -> None:
    with announced(name, 7007):
        assert found({cut})[cut].port == 7007


MOVING = """
import subprocess, sys, time
from ml2_receiver.transport import discovery
from ml2_receiver.transport.discovery import Announcement, find_receivers

discovery._UPDATE_S = 0.2

def ip(*words):
    subprocess.run(["ip", *words], check=True)

def await_addresses(expected):
    deadline_s = time.monotonic() + 40
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


@pytest.mark.timeout(240)
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can make a network of its own")
def test_addresses_that_come_and_go_are_followed() -> None:
    moving = subprocess.run(
        ["unshare", "--net", sys.executable, "-c", MOVING],
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
