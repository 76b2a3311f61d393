"""Finds messages that several files of a recording have."""

from collections import deque
from itertools import takewhile
from typing import NamedTuple, Protocol

# Two recorders log a message at different times, by their load and by their machines' clocks.
LAG_NS = 10_000_000_000


class _Message(Protocol):
    @property
    def topic(self) -> str: ...
    @property
    def time_ns(self) -> int: ...
    @property
    def payload(self) -> bytes: ...


class _Taken(NamedTuple):
    key: int
    time_ns: int
    files: set[int]


class Copies:
    """Tells which messages to leave out, so that those that several files have come once.

    A recovered file beside its original has the same messages, but may lack the first or the last
    ones. A second recorder of the same topics has them with other times. Files have the messages of
    a topic in the same order, and equal messages of one file are no copies.

    Attributes:
        count: the number of copies so far.
    """

    def __init__(self) -> None:
        self.count = 0
        self._by_key: dict[int, deque[_Taken]] = {}
        self._taken: deque[_Taken] = deque()

    def is_copy(self, file: int, message: _Message) -> bool:
        """Takes the next message, in the order of their times; returns True if another file had it.

        Messages are remembered by their hash for LAG_NS.
        """
        self._forget_before(message.time_ns - LAG_NS)
        key = hash((message.topic, message.payload))
        taken = self._by_key.setdefault(key, deque())
        later = list(takewhile(lambda it: file not in it.files, reversed(taken)))
        if later:
            # Messages of one time are in the order of the files.
            first = [it for it in later if it.time_ns == later[0].time_ns][-1]
            first.files.add(file)
            self.count += 1
            return True
        taken.append(_Taken(key, message.time_ns, {file}))
        self._taken.append(taken[-1])
        return False

    def _forget_before(self, time_ns: int) -> None:
        while self._taken and self._taken[0].time_ns < time_ns:
            key = self._taken.popleft().key
            taken = self._by_key[key]
            taken.popleft()
            if not taken:
                del self._by_key[key]
