"""The option --link of the demo, where there can be no link."""

import importlib.util
import os
import socket
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType
from typing import Literal

import pytest

import shaped_link
from delayed_link import Direction
from shaped_link import Machine, link, why_not


@pytest.fixture
def demo(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ModuleType:
    """The demo's main module, which writes to a folder of the test."""
    file = Path(shaped_link.__file__).with_name("__main__.py")
    spec = importlib.util.spec_from_file_location("demo_main", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "OUTPUT", tmp_path)
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    return module


def test_a_packet_arrives_when_it_is_sent_and_has_taken_the_delay() -> None:
    ends = [end for _ in range(2) for end in socket.socketpair(type=socket.SOCK_DGRAM)]
    with ExitStack() as stack:
        for end in ends:
            stack.enter_context(end).setblocking(False)
        way = Direction(ends[1].fileno(), ends[2].fileno(), 0.5, bytes_per_s=1000, queue_s=1)
        for length in (1000, 1000, 1):
            ends[0].send(bytes(length))
        way.take(0)
        assert (way.deliver(0), way.dropped) == (1.5, 1)
        assert way.deliver(1.5) == 2.5
        assert len(ends[3].recv(2000)) == 1000


@pytest.mark.parametrize(
    ("way_back", "bytes_sent"),
    [("free", [100_000]), ("own", [100_000, 300_000]), ("shared", [400_000])],
)
def test_what_both_ways_of_a_link_send_goes_through_the_buckets_that_are_asked_for(
    way_back: Literal["free", "own", "shared"], bytes_sent: list[int]
) -> None:
    if reason := why_not():
        pytest.skip(reason)
    with ExitStack() as stack:
        made = stack.enter_context(link("cubic", 1000, way_back=way_back))
        headset, receiver = (
            stack.enter_context(socket_of(it)) for it in (made.headset, made.receiver)
        )
        for sender, other, messages in ((headset, receiver, 100), (receiver, headset, 300)):
            for _ in range(messages):
                sender.sendto(bytes(1000), other.getsockname())
                assert len(other.recv(2000)) == 1000
        # Each message has headers; the rest are those by which machines find each other
        for expected, found in zip(bytes_sent, made.sent_bytes(), strict=True):
            assert 1.04 * expected < found < 1.04 * expected + 10_000


def socket_of(machine: Machine) -> socket.socket:
    """Returns a socket of UDP in the namespace of a machine."""

    def make() -> socket.socket:
        with Path("/run/netns", str(machine.prefix[-1])).open() as file:
            os.setns(file.fileno(), os.CLONE_NEWNET)  # for this thread alone
        return socket.socket(type=socket.SOCK_DGRAM)

    with ThreadPoolExecutor(1) as thread:
        made = thread.submit(make).result()
    made.settimeout(10)
    made.bind((machine.address, 0))
    return made


def starts_no_process(*command: object) -> None:
    raise AssertionError(f"started {command}")


@pytest.mark.parametrize("link", ["abc", "0", "-1", "nan", "inf"])
def test_a_link_is_a_rate_above_0(
    demo: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    link: str,
) -> None:
    monkeypatch.setattr(sys, "argv", ["demo", "--link", link])
    with pytest.raises(SystemExit, match="2"):
        demo.main()
    expected = f"make demo: error: argument --link: expected a number above 0, found '{link}'\n"
    assert capsys.readouterr().err.endswith(expected)


@pytest.mark.parametrize(
    ("user", "words"),
    [
        (1000, "only root may make network namespaces; try: sudo make demo LINK=100"),
        (0, "this machine makes no links: [Errno 2] no such program: ip"),
    ],
)
def test_where_there_can_be_no_link_nothing_is_started(
    demo: ModuleType, monkeypatch: pytest.MonkeyPatch, user: int, words: str
) -> None:
    def run(*_: object) -> str:
        raise FileNotFoundError(2, "no such program: ip")

    monkeypatch.setattr(os, "geteuid", lambda: user)
    monkeypatch.setattr(shaped_link, "_run", run)
    monkeypatch.setattr(demo, "offered", starts_no_process)
    monkeypatch.setattr(sys, "argv", ["demo", "--link", "100"])
    with pytest.raises(SystemExit) as ended:
        demo.main()
    assert str(ended.value) == f"no link of 100 Mbit/s: {words}"
