"""The demo says when the processors are full, and only then."""

import io
import os
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

import processors
from left_out import left_out, words
from live_table import LiveTable
from processors import Load, Usage, usage, warning

_BEGIN = Usage(2, 2, 100.0, 1000.0)
_WORDS = "2 of 2 processors 98 % busy: latencies are this machine's"


def _later(busy_s: float, passed_s: float) -> Usage:
    return Usage(2, 2, 100.0 + busy_s, 1000.0 + passed_s)


def test_says_how_busy_full_processors_were() -> None:
    assert warning(_BEGIN, _later(19.6, 20.0)) == _WORDS


@pytest.mark.parametrize("busy_s", [0.0, 10.0, 17.9])
def test_is_silent_while_there_is_time_left(busy_s: float) -> None:
    assert warning(_BEGIN, _later(busy_s, 20.0)) is None


def test_is_silent_before_any_time_has_passed() -> None:
    assert warning(_BEGIN, _BEGIN) is None


def test_counts_only_processors_that_the_demo_may_use() -> None:
    before = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(before)})
        one = usage()
    finally:
        os.sched_setaffinity(0, before)
    assert (one.usable, one.existing) == (1, os.cpu_count())
    assert 0 < one.busy_s < one.passed_s


def _takes(monkeypatch: pytest.MonkeyPatch, *usages: Usage) -> None:
    left = iter(usages)
    monkeypatch.setattr(processors, "usage", lambda: next(left))


def test_measures_from_the_first_message_to_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    """Starting programs is not in the table's latencies, and neither is the quiet end."""
    _takes(monkeypatch, _later(0.0, 100.0), _later(19.6, 120.0))
    load = Load()
    assert [load.note(messages) for messages in (0, 5, 90, 90)] == [None, None, _WORDS, _WORDS]


def test_stays_in_the_last_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """The final snapshot comes after a quiet wait for late messages, which it does not count."""
    _takes(monkeypatch, _BEGIN, _later(19.6, 20.0))
    shown = io.StringIO()
    with LiveTable(Console(file=shown, width=150), "/ml2", "simulated") as table:
        for count, final in ((5, False), (90, False), (91, True)):
            table.show(_snapshot(count, final))
    assert _WORDS in shown.getvalue()


def _snapshot(count: int, final: bool) -> dict[str, Any]:
    seen: dict[str, Any] = {"count": count, "stream": "imu", "type": "sensor_msgs/msg/Imu"}
    seen |= {"first_s": 0.0, "last_s": 1.0, "bytes": 1, "rate_hz": 1.0}
    seen |= {"latency_ms": {"p50": 1.0, "p99": 1.0}, "diagnostics": {}}
    nothing: dict[str, Any] = {"streams": {}, "clock": {}, "adaptation": "", "is_mixed": False}
    return nothing | {"topics": {"/ml2/imu": seen}, "final": final}


def test_the_newest_count_of_each_camera_is_shown(tmp_path: Path) -> None:
    log = tmp_path / "headset.log"
    log.write_text(
        "connected to desk\n"
        "ml2sim: world camera: 7 captures left out so far, while frames were rendered\n"
        "ml2sim: mixed reality camera: 3 captures left out so far, while frames were rendered\n"
        "ml2sim: world camera: 55 captures left out so far, while frames were rendered\n"
    )
    assert left_out(log) == {"world": 55, "mixed reality": 3}
    shown = words(left_out(log))
    assert shown is not None
    assert shown.endswith(": world 55, mixed reality 3")


def test_nothing_is_said_of_a_headset_that_left_out_nothing(tmp_path: Path) -> None:
    log = tmp_path / "headset.log"
    log.write_text("ml2sim: misuse: world camera: released twice\n")
    assert left_out(log) == {}
    assert words({}) is None
