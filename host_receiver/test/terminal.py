"""Commands on a terminal of their own."""

import os
import pty
import re
import subprocess
import sys
import termios
from contextlib import suppress
from typing import Self

from ros_processes import environment

_COLOURS = re.compile(rb"\x1b\[[0-9;?]*[A-Za-z]")


def plain(shown: bytes) -> str:
    """Returns the shown text without its colours."""
    return _COLOURS.sub(b"", shown).decode()


class OnTerminal:
    """`ml2-receiver` with these arguments, on 80 columns; killed when left."""

    def __init__(self, *arguments: str) -> None:
        self._terminal, inner = pty.openpty()
        termios.tcsetwinsize(inner, (40, 80))
        self.process = subprocess.Popen(
            ["setsid", "--ctty", sys.executable, "-m", "ml2_receiver", *arguments],
            stdin=inner,
            stdout=inner,
            stderr=inner,
            env={**environment(), "TERM": "xterm"},
        )
        os.close(inner)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._terminal)

    def await_shown(self, pattern: bytes) -> bytes:
        """Waits until what is shown from now on, without its colours, has this; returns all."""
        shown = b""
        while not re.search(pattern, _COLOURS.sub(b"", shown)):
            try:
                shown += os.read(self._terminal, 1024)
            except OSError as error:  # the terminal ends with the process
                raise AssertionError(f"expected {pattern!r}, found {plain(shown)!r}") from error
        return shown

    def press(self, keys: bytes) -> None:
        os.write(self._terminal, keys)

    def read_to_the_end(self) -> None:
        """Reads until the command ends, which may wait for its reader before."""
        with suppress(OSError):  # the terminal ends with the process
            while os.read(self._terminal, 1024):
                pass
