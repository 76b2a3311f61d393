"""The option --link of the demo, where there can be no link."""

import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType

import pytest

import shaped_link


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
