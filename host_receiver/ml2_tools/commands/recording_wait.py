"""Waits for the end of a recording and shows its progress."""

import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

from ml2_receiver.printable import markup

_REDRAW_S = 0.5


@dataclass(frozen=True)
class Standing:
    """A recording at the moment; `text` is for people."""

    duration_s: float
    file_bytes: int
    messages: int
    text: str
    is_over: bool = False


def how_long(duration_s: float | None) -> str:
    return f"{f'for {duration_s:g} s, or ' if duration_s else ''}until Ctrl-C"


def wait(
    stopping: threading.Event, duration_s: float | None, standing: Callable[[], Standing]
) -> None:
    """Returns when the recording has lasted `duration_s`, has ended, or the user ends it.

    On a terminal it shows how it stands.
    """
    end_s: float | None = None
    began_s = last_s = time.monotonic()
    last = standing()
    with ExitStack() as stack:
        live = None
        if sys.stdout.isatty():
            from rich.live import Live

            live = stack.enter_context(Live(auto_refresh=False, transient=True))
        while not last.is_over:
            if end_s is None and duration_s is not None and last.messages:
                # A clock that steps makes a recording seem longer than it can be.
                end_s = last_s + duration_s - min(last.duration_s, last_s - began_s)
            left_s = _REDRAW_S if end_s is None else end_s - time.monotonic()
            if left_s <= 0 or stopping.wait(min(_REDRAW_S, left_s)):
                return
            now_s, now = time.monotonic(), standing()
            if live is not None:
                rate = (now.file_bytes - last.file_bytes) / (now_s - last_s)
                live.update(f"{markup(now.text)}, {rate / 1e6:.1f} MB/s", refresh=True)
            last_s, last = now_s, now
