"""What the link to a headset carries besides its streams, tried with filler."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from ..errors import ErrorCode, LinkTestError, ProtocolError
from ..wire.messages import MAX_LINK_TEST_BYTES, LinkTest

_PATIENCE_S = 8.0  # PROTOCOL.md, Link test

type LinkTestState = Literal["running", "measured", "unanswered"]


@dataclass(frozen=True)
class Throughput:
    """A link test; `number` counts those of a session from 1.

    Once it is measured, `filler_bytes` arrived, and in the `duration_s` between the first frame of
    them and their end so much per second: of filler, `free_mbit_per_s`, and of the streams beside
    it, `streams_mbit_per_s`; of both the payloads alone count.
    """

    number: int
    state: LinkTestState
    filler_bytes: int = 0
    duration_s: float = 0.0
    free_mbit_per_s: float = 0.0
    streams_mbit_per_s: float = 0.0


@dataclass(frozen=True)
class _Mark:
    time_s: float
    filler_bytes: int
    stream_bytes: int


class LinkTrial:
    """The link tests of one session, one at a time. Not thread-safe.

    Args:
        clock: monotonic time in s.
        stream_bytes: what has arrived of the streams so far.
    """

    def __init__(self, clock: Callable[[], float], stream_bytes: Callable[[], int]) -> None:
        self._clock, self._stream_bytes = clock, stream_bytes
        self._number = 0
        self._asked_s: float | None = None
        self._filler_bytes = 0
        self._first: _Mark | None = None
        self._last: _Mark | None = None

    def ask(self) -> LinkTest:
        """The LINK_TEST to send.

        Raises:
            LinkTestError: the last one has not ended.
        """
        match self._state:
            case "running":
                raise LinkTestError("the link is being tested already")
            case "unanswered":
                raise LinkTestError("the headset does not answer: its app knows no link test")
        self._number += 1
        self._asked_s = self._clock()
        self._filler_bytes = 0
        self._first = self._last = None
        return LinkTest(MAX_LINK_TEST_BYTES)

    def filled(self, length: int) -> None:
        """A FILLER frame with a body of this length arrived; 0 ends the test.

        Raises:
            ProtocolError: `unexpected`.
        """
        if self._asked_s is None:
            raise ProtocolError(ErrorCode.UNEXPECTED, "FILLER that was not asked for")
        self._filler_bytes += length
        if self._filler_bytes > MAX_LINK_TEST_BYTES:
            raise ProtocolError(
                ErrorCode.UNEXPECTED,
                f"FILLER of more than {MAX_LINK_TEST_BYTES} B was not asked for",
            )
        if self._first is None:
            self._first = self._mark()
        if not length:
            self._last = self._mark()
            self._asked_s = None

    def _mark(self) -> _Mark:
        return _Mark(self._clock(), self._filler_bytes, self._stream_bytes())

    @property
    def _state(self) -> LinkTestState:
        if self._asked_s is None:
            return "measured"
        return "running" if self._clock() - self._asked_s <= _PATIENCE_S else "unanswered"

    def report(self) -> Throughput | None:
        """The last test; None when there was none."""
        if not self._number:
            return None
        first, last = self._first, self._last
        if first is None or last is None:
            return Throughput(self._number, self._state)
        duration_s = last.time_s - first.time_s
        per_second = 8e-6 / duration_s if duration_s > 0 else 0.0
        return Throughput(
            self._number,
            "measured",
            last.filler_bytes,
            duration_s,
            (last.filler_bytes - first.filler_bytes) * per_second,
            (last.stream_bytes - first.stream_bytes) * per_second,
        )
