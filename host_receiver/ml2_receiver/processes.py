"""Who runs on this machine, from /proc; of other users' processes little can be read."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

_PROC = Path("/proc")
_LISTEN = "0A"  # include/net/tcp_states.h


@dataclass(frozen=True)
class Process:
    """A process; `command` is its command line."""

    pid: int
    name: str
    command: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.name} (pid {self.pid})"

    def environment(self, variable: str) -> str | None:
        """The value it was started with; None when unset or unreadable."""
        with suppress(OSError):
            for item in (_PROC / str(self.pid) / "environ").read_bytes().split(b"\0"):
                name, _, value = item.decode(errors="replace").partition("=")
                if name == variable:
                    return value
        return None


def processes() -> Iterator[Process]:
    """All processes whose names can be read."""
    for folder in _PROC.iterdir():
        if not folder.name.isdecimal():
            continue
        with suppress(OSError):  # it may just have ended
            command = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
            name = (folder / "comm").read_text(errors="replace").strip()
            yield Process(int(folder.name), name, tuple(filter(None, command)))


def receivers() -> list[Process]:
    """Those that are `ml2-receiver run`."""
    return [process for process in processes() if is_receiver(process.command)]


def is_receiver(command: tuple[str, ...]) -> bool:
    """Whether a command line is that of `ml2-receiver run`, by script or by module."""
    if "run" not in command:
        return False
    started = command[: command.index("run")]
    return any(word == "ml2_receiver" or Path(word).name == "ml2-receiver" for word in started)


def listener_of(port: int) -> Process | None:
    """Who listens on a TCP port; None when nobody, or another user, does."""
    sockets = {f"socket:[{inode}]" for inode in _listening_inodes(port)}
    return next((process for process in processes() if sockets & _open_files(process.pid)), None)


def is_listened_on(port: int) -> bool:
    """Whether anybody listens on a TCP port."""
    return any(_listening_inodes(port))


def _listening_inodes(port: int) -> Iterator[str]:
    for table in ("tcp", "tcp6"):
        with suppress(FileNotFoundError):  # without IPv6
            for row in (_PROC / "net" / table).read_text().splitlines()[1:]:
                _, local, _, state, *_, inode = row.split()[:10]
                if state == _LISTEN and int(local.rpartition(":")[2], 16) == port:
                    yield inode


def _open_files(pid: int) -> set[str]:
    files = set()
    with suppress(OSError):
        for file in (_PROC / str(pid) / "fd").iterdir():
            with suppress(OSError):
                files.add(str(file.readlink()))
    return files
