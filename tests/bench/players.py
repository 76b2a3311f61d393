"""Runs processes that publish or subscribe for a benchmark and measures them; see roles.py."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

_ROLES = Path(__file__).with_name("roles.py")


class Usage(NamedTuple):
    """CPU time, wall time and published frames, each since an arbitrary start."""

    cpu_s: float
    time_s: float
    frames: int


class Player:
    """A role in its own process; a context manager."""

    def __init__(self, role: str, *arguments: str) -> None:
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(
            [sys.executable, _ROLES, role, *arguments], stdin=pipe, stdout=pipe, text=True
        )
        self.role = role

    def __enter__(self) -> Player:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate()

    def line(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline().strip()
        if not line:
            raise SystemExit(f"the {self.role} ended early")
        return line

    def usage(self, count: int) -> Usage:
        """Waits until `count` frames are published (a subscriber: received); returns the usage."""
        cpu_s, time_s, frames = self.answer(count)
        return Usage(cpu_s, time_s, round(frames))

    def answer(self, question: int = 0) -> list[float]:
        """Writes a line to the player, and returns the numbers with which it answers."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{question}\n")
        self._process.stdin.flush()
        found: list[float] = json.loads(self.line())
        return found


class Turn:
    """The measurements of one player.

    Args:
        usage: waits for a number of frames and returns the player's usage.

    Attributes:
        results: CPU ms per frame and frames per s of each call of play().
        lost: the number of frames that were sent and never counted.
    """

    def __init__(self, usage: Callable[[int], Usage]) -> None:
        self.results: list[tuple[float, float]] = []
        self.lost = 0
        self._usage = usage
        self._sent = 0

    def play(self, send: Callable[[], None], frames: int) -> None:
        """Sends frames as fast as the player takes them, and adds a result."""
        before = self._usage(self._sent - self.lost)
        for _ in range(frames):
            send()
        self._sent += frames
        after = self._usage(self._sent - self.lost)
        counted = after.frames - before.frames
        self.lost = self._sent - after.frames
        cpu_ms, time_s = (after.cpu_s - before.cpu_s) * 1000, after.time_s - before.time_s
        self.results.append((cpu_ms / counted, counted / time_s))
