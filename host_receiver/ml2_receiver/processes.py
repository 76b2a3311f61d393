"""Processes on this machine; little can be read about those of other users."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil


@dataclass(frozen=True)
class Process:
    """A process; `command` is its command line, empty if it cannot be read."""

    pid: int
    name: str
    command: tuple[str, ...]

    def __str__(self) -> str:
        name = "ml2-receiver" if self.is_ours else self.name  # which is that of the interpreter
        return f"{name} (pid {self.pid})"

    @property
    def is_ours(self) -> bool:
        return _is_ours(self.command)

    def environment(self, variable: str) -> str | None:
        """Returns a variable's value at the start of the process; None if unset or unreadable."""
        with suppress(psutil.Error):
            return psutil.Process(self.pid).environ().get(variable)
        return None


def processes() -> Iterator[Process]:
    """Yields all processes."""
    for process in psutil.process_iter(["name", "cmdline"]):
        yield Process(process.pid, process.info["name"], tuple(process.info["cmdline"] or ()))


def receivers() -> list[Process]:
    """Returns the processes that are `ml2-receiver run`."""
    return [process for process in processes() if is_receiver(process.command)]


def is_receiver(command: tuple[str, ...]) -> bool:
    """Returns True if a command line runs `ml2-receiver run`, by script or by module."""
    if "run" not in command:
        return False
    return _is_ours(command[: command.index("run")])


def _is_ours(words: Iterable[str]) -> bool:
    return any(word == "ml2_receiver" or Path(word).name == "ml2-receiver" for word in words)


def listener_of(port: int) -> Process | None:
    """Returns the process that listens on a TCP port; None if none does, or another user's."""
    listening = {connection.pid for connection in _listening_on(port)}
    return next((process for process in processes() if process.pid in listening), None)


def is_listened_on(port: int) -> bool:
    """Returns True if any process listens on a TCP port."""
    return any(_listening_on(port))


def _listening_on(port: int) -> Iterator[Any]:
    for connection in psutil.net_connections("tcp"):
        if (
            connection.status == psutil.CONN_LISTEN
            and connection.laddr
            and connection.laddr.port == port
        ):
            yield connection
