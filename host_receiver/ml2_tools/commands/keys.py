"""Reads the keyboard while a command runs."""

import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Callable, Mapping
from typing import Self

LEFT, RIGHT = "\x1b[D", "\x1b[C"
_LONGEST = 16


class Keys:
    """Calls a function for each pressed key, in an own thread; a context manager.

    Does nothing if standard input is not a terminal, or if this process is in the background.
    """

    def __init__(self, actions: Mapping[str, Callable[[], None]]) -> None:
        self._actions = actions
        self._thread = threading.Thread(target=self._listen, name="keys")

    def __enter__(self) -> Self:
        self._is_reading = _is_in_foreground()
        if self._is_reading:
            self._terminal = sys.stdin.fileno()
            self._modes = termios.tcgetattr(self._terminal)
            self._stop_read, self._stop_write = os.pipe()
            tty.setcbreak(self._terminal)
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._is_reading:
            os.write(self._stop_write, b"\0")
            self._thread.join()
            termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._modes)
            os.close(self._stop_read)
            os.close(self._stop_write)

    def _listen(self) -> None:
        while True:
            ready, _, _ = select.select([self._terminal, self._stop_read], [], [])
            if self._stop_read in ready:
                return
            pressed = os.read(self._terminal, _LONGEST)
            if not pressed:
                return
            action = self._actions.get(pressed.decode(errors="replace"))
            if action is not None:
                action()


def _is_in_foreground() -> bool:
    if not sys.stdin.isatty():
        return False
    try:
        return os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except OSError:  # not the controlling terminal
        return False
