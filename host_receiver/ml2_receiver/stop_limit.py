"""Ends this process if a thread that hangs keeps it from stopping."""

import os
import sys
import threading
import time

STOP_S = 4.0


class StopLimit:
    """How long the stop of this process may take. Thread-safe."""

    def __init__(self) -> None:
        self._progress_s = 0.0
        self._over = threading.Event()

    def making_progress(self) -> None:
        """Gives a stop under way another STOP_S: data are being written."""
        self._progress_s = time.monotonic()

    def reached(self) -> None:
        """Ends the stop under way: what was to stop has stopped, and the process goes on."""
        self._over.set()

    def enforce(self) -> None:
        """Ends the process, with exit code 2, unless it ends by itself within STOP_S.

        Called by a daemon thread. It names on stderr what each thread does that it did not wait
        for. It returns if the stop is reached before.
        """
        self._over.clear()
        self.making_progress()
        while (left_s := self._progress_s + STOP_S - time.monotonic()) > 0:
            if self._over.wait(left_s):
                return
        hanging = "; ".join(_what_each_does())
        os.write(sys.stderr.fileno(), f"ended without waiting for what hangs: {hanging}\n".encode())
        os._exit(2)


STOP_LIMIT = StopLimit()


def _what_each_does() -> list[str]:
    """By the frames alone: a thread that hangs may hold the lock of the list of threads."""
    own = threading.get_ident()
    return [
        f"{frame.f_code.co_qualname} ({frame.f_code.co_filename}:{frame.f_lineno})"
        for thread, frame in sys._current_frames().items()
        if thread != own
    ]
