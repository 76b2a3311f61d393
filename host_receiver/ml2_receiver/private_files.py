"""Files and folders that other users of this machine cannot read, whatever the umask is."""

import os
from collections.abc import Buffer
from contextlib import suppress
from io import BufferedRandom
from itertools import takewhile
from pathlib import Path

_FILE, _FOLDER = 0o600, 0o700
_EMPTY = os.O_CREAT | os.O_TRUNC


def create_private_file(path: Path) -> BufferedRandom:
    """Opens an empty file for reading and writing; a new one has the mode 0600.

    Raises:
        OSError: it cannot be opened.
    """
    return os.fdopen(os.open(path, os.O_RDWR | _EMPTY, _FILE), "w+b")


def write_private_file(path: Path, data: Buffer) -> None:
    """Writes a file; a new one has the mode 0600.

    Raises:
        OSError: it cannot be written.
    """
    with os.fdopen(os.open(path, os.O_WRONLY | _EMPTY, _FILE), "wb") as file:
        file.write(data)


def make_private_folder(folder: Path) -> None:
    """Makes a folder of the mode 0700, and so each missing folder above it.

    Raises:
        FileExistsError: it exists.
        OSError: it cannot be made.
    """
    missing = list(takewhile(lambda it: not it.exists(), folder.parents))
    for it in reversed(missing):
        with suppress(FileExistsError):  # another process has just made it
            it.mkdir(mode=_FOLDER)
    folder.mkdir(mode=_FOLDER)
