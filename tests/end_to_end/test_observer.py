"""The end of the independent subscriber, with a clock that the test sets."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Any, cast

import pytest

import observer
from observer import Observer, observe


@dataclass
class Ended:
    """An observer of a session that has ended, to which messages come at these times."""

    times_s: list[float]
    published: int
    now_s: float = 0.0
    topics: tuple[str, ...] = ("topic",)
    is_configured: threading.Event = field(default_factory=threading.Event)
    is_final: threading.Event = field(default_factory=threading.Event)

    def __post_init__(self) -> None:
        self.is_configured.set()
        self.is_final.set()

    def is_matched(self) -> bool:
        return True

    def start_headset(self) -> None:
        pass

    @property
    def count(self) -> int:
        return sum(it <= self.now_s for it in self.times_s)

    def awaits_more(self) -> bool:
        return self.count < self.published

    def monotonic(self) -> float:
        return self.now_s

    def sleep(self, duration_s: float) -> None:
        self.now_s += duration_s


@pytest.mark.parametrize(
    ("times_s", "lost", "end_s"),
    [([0.0], 0, 0), ([0, 3.5, 7.0], 0, 7), ([0, 3.5], 1, 7.5)],
    ids=["all are here", "late ones", "a lost one"],
)
def test_it_ends_with_the_last_message_or_when_no_more_come(
    monkeypatch: pytest.MonkeyPatch, times_s: list[float], lost: int, end_s: float
) -> None:
    """A message that was lost on the way comes when Fast DDS tells of it, each 3 s."""
    ended = Ended(times_s, len(times_s) + lost)
    monkeypatch.setattr(observer, "time", ended)
    observe(cast(Any, ended))
    assert ended.now_s == pytest.approx(end_s, abs=0.15)


def test_it_counts_the_messages_of_all_topics() -> None:
    class Two:
        topics = {"a": Ended([0], 1), "b": Ended([0, 0], 2)}  # noqa: RUF012

    assert Observer.count.fget(cast(Any, Two())) == 3  # type: ignore[attr-defined]
