"""Ends this process if a thread that hangs keeps it from stopping."""

import faulthandler
import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress

STOP_S = 4.0
_LOCKED_S = 0.9


class StopLimit:
    """Limits how long the stop of this process takes. Thread-safe."""

    def __init__(self) -> None:
        self._progress_s = 0.0
        self._over = threading.Event()

    def making_progress(self) -> None:
        """Gives a stop under way another STOP_S: data are being written."""
        self._progress_s = time.monotonic()

    def reached(self) -> None:
        """Ends the stop under way: what was to stop has stopped, and the process goes on."""
        self._over.set()

    def enforce(self, begin: Callable[[], object] = lambda: None) -> None:
        """Ends the process, with exit code 2, unless it ends by itself within STOP_S.

        Called by a daemon thread. It names on stderr what each thread does that it did not wait
        for. It returns if the stop is reached before. A call that hangs without giving Python's
        lock back, so that no thread runs, ends the process _LOCKED_S later, with exit code 1.

        Args:
            begin: begins the stop, once the limit holds.
        """
        self._over.clear()
        self.making_progress()
        self._end_without_python(STOP_S)
        begin()
        while (left_s := self._progress_s + STOP_S - time.monotonic()) > 0:
            self._end_without_python(left_s)
            if self._over.wait(left_s):
                faulthandler.cancel_dump_traceback_later()
                return
        hanging = "; ".join(_what_each_does())
        with suppress(OSError):
            os.write(
                sys.stderr.fileno(), f"ended without waiting for what hangs: {hanging}\n".encode()
            )
        os._exit(2)

    @staticmethod
    def _end_without_python(left_s: float) -> None:
        faulthandler.dump_traceback_later(left_s + _LOCKED_S, file=sys.stderr.fileno(), exit=True)


STOP_LIMIT = StopLimit()


def _what_each_does() -> list[str]:
    """By the frames alone: a thread that hangs may hold the lock of the list of threads."""
    own = threading.get_ident()
    return [
        f"{frame.f_code.co_qualname} ({frame.f_code.co_filename}:{frame.f_lineno})"
        for thread, frame in sys._current_frames().items()
        if thread != own
    ]
