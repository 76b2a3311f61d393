"""The option --link of the demo, where there can be no link."""

import importlib.util
import os
import socket
import sys
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType

import pytest

import shaped_link
from delayed_link import Direction, Rate


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


@pytest.mark.parametrize(("is_shared", "second_s"), [(False, 1.0), (True, 2.0)])
def test_both_ways_of_a_link_wait_for_each_other_where_they_share_its_rate(
    is_shared: bool, second_s: float
) -> None:
    rate = Rate(1000)
    rates = (rate, rate if is_shared else Rate(1000))
    with ExitStack() as stack:
        ends = [
            stack.enter_context(end)
            for _ in range(4)
            for end in socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
        ]
        for end in ends:
            end.setblocking(False)
        fds = [it.fileno() for it in ends]
        ways = [Direction(fds[4 * n + 1], fds[4 * n + 2], 0.5, it, 9) for n, it in enumerate(rates)]
        for n, way in enumerate(ways):
            ends[4 * n].send(bytes(1000))
            way.take(0)
        assert [way.deliver(0) for way in ways] == [1.5, second_s + 0.5]
        ways[1].deliver(second_s + 0.5)
        assert len(ends[7].recv(2000)) == 1000


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
