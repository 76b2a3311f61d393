"""Reads and replaces files as a whole."""

import os
import stat
import tempfile
from contextlib import suppress
from io import BufferedReader
from pathlib import Path

_EXPECTED = "expected a regular file"


def read_file(path: Path, most_bytes: int) -> bytes:
    """Returns the content of a file, or the first `most_bytes` + 1 of it.

    Raises:
        OSError: as open_file().
    """
    with open_file(path) as file:
        return file.read(most_bytes + 1)


def open_file(path: Path) -> BufferedReader:
    """Opens a regular file for reading; never waits.

    For paths that others name: opening a named pipe or a terminal would wait for its other end.

    Raises:
        OSError: it cannot be read, or is no regular file.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError(0, _EXPECTED)
    return os.fdopen(descriptor, "rb")


def replace_file(path: Path, data: bytes) -> None:
    """Puts a new file in the place of the old one, all or nothing, with its permissions.

    Raises:
        OSError: it cannot be written, is read-only, or is no regular file.
    """
    mode = path.stat().st_mode if path.exists() else stat.S_IFREG | 0o644
    if not stat.S_ISREG(mode):
        raise OSError(0, _EXPECTED)
    if not mode & stat.S_IWUSR:  # replacing needs no permission to write it
        raise PermissionError(0, "it is read-only")
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        Path(name).chmod(stat.S_IMODE(mode))
        Path(name).replace(path)
    except OSError:
        with suppress(OSError):
            Path(name).unlink()
        raise
