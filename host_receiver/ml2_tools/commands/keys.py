"""Keys that are pressed while a command runs."""

import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Self

LEFT, RIGHT = "\x1b[D", "\x1b[C"
_LONGEST = 16


class Keys:
    """Calls a function for each key, in a thread of its own, while it is entered.

    It does nothing where standard input is no terminal, or another job has it.
    """

    def __init__(self, actions: Mapping[str, Callable[[], None]]) -> None:
        self._actions = actions
        self._thread = threading.Thread(target=self._listen, name="keys")

    def __enter__(self) -> Self:
        self._is_ours = _has_terminal()
        if self._is_ours:
            self._terminal = sys.stdin.fileno()
            self._modes = termios.tcgetattr(self._terminal)
            self._left, self._leaving = os.pipe()
            tty.setcbreak(self._terminal)
            self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: object, trace: TracebackType | None
    ) -> None:
        if self._is_ours:
            os.write(self._leaving, b"\0")
            self._thread.join()
            termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._modes)
            os.close(self._left)
            os.close(self._leaving)

    def _listen(self) -> None:
        while True:
            ready, _, _ = select.select([self._terminal, self._left], [], [])
            if self._left in ready:
                return
            pressed = os.read(self._terminal, _LONGEST)
            if not pressed:
                return
            action = self._actions.get(pressed.decode(errors="replace"))
            if action is not None:
                action()


def _has_terminal() -> bool:
    if not sys.stdin.isatty():
        return False
    try:
        return os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except OSError:  # a terminal that controls no job
        return False
