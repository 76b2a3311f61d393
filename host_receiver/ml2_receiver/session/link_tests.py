"""Link tests: the free throughput of the link to a headset, measured with filler."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from ..errors import ErrorCode, LinkTestError, ProtocolError
from ..wire.messages import MAX_LINK_TEST_BYTES, LinkTest

_TIMEOUT_S = 8.0  # PROTOCOL.md, Link test

type LinkTestState = Literal["running", "measured", "unanswered"]


@dataclass(frozen=True)
class LinkTestResult:
    """The result of a link test; `number` counts the tests of a session from 1.

    The other fields are 0 until `state` is "measured". `filler_bytes` is all filler that arrived.
    `free_mbit_per_s` is the rate of the filler in the `duration_s` between its first and its last
    frame, `streams_mbit_per_s` that of the streams in the same time. Only payloads count.
    """

    number: int
    state: LinkTestState
    filler_bytes: int = 0
    duration_s: float = 0.0
    free_mbit_per_s: float = 0.0
    streams_mbit_per_s: float = 0.0


@dataclass(frozen=True)
class _Sample:
    time_s: float
    filler_bytes: int
    stream_bytes: int


class LinkTests:
    """The link tests of one session, one at a time; `now_s` is monotonic time. Not thread-safe.

    Args:
        stream_bytes: returns the payload bytes of the streams that have arrived so far.
    """

    def __init__(self, stream_bytes: Callable[[], int]) -> None:
        self._stream_bytes = stream_bytes
        self._number = 0
        self._asked_s: float | None = None
        self._filler_bytes = 0
        self._first: _Sample | None = None
        self._last: _Sample | None = None

    def ask(self, now_s: float) -> LinkTest:
        """Starts a test and returns the LINK_TEST to send.

        Raises:
            LinkTestError: the last test is running, or was not answered.
        """
        match self._state(now_s):
            case "running":
                raise LinkTestError("the link is being tested already")
            case "unanswered":
                raise LinkTestError("the headset does not answer: its app has no link test")
        self._number += 1
        self._asked_s = now_s
        self._filler_bytes = 0
        self._first = self._last = None
        return LinkTest(MAX_LINK_TEST_BYTES)

    def filled(self, length: int, now_s: float) -> None:
        """Counts a FILLER frame with a body of `length` bytes; 0 ends the test.

        Raises:
            ProtocolError: `unexpected`; no filler, or not as much, was asked for.
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
            self._first = self._sample(now_s)
        if not length:
            self._last = self._sample(now_s)
            self._asked_s = None

    def _sample(self, now_s: float) -> _Sample:
        return _Sample(now_s, self._filler_bytes, self._stream_bytes())

    def _state(self, now_s: float) -> LinkTestState:
        if self._asked_s is None:
            return "measured"
        return "running" if now_s - self._asked_s <= _TIMEOUT_S else "unanswered"

    def report(self, now_s: float) -> LinkTestResult | None:
        """Returns the last test, or None before the first one."""
        if not self._number:
            return None
        first, last = self._first, self._last
        if first is None or last is None:
            return LinkTestResult(self._number, self._state(now_s))
        duration_s = last.time_s - first.time_s
        per_second = 8e-6 / duration_s if duration_s > 0 else 0.0
        return LinkTestResult(
            self._number,
            "measured",
            last.filler_bytes,
            duration_s,
            (last.filler_bytes - first.filler_bytes) * per_second,
            (last.stream_bytes - first.stream_bytes) * per_second,
        )
