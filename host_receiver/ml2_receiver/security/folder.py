"""The folder of keys and paired devices."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from fcntl import LOCK_EX, flock
from pathlib import Path

from ..errors import KeysError, file_hint
from ..private_files import make_private_folder, write_private_file

_OTHERS_WRITE = 0o022
REMOVE_HINT = "Remove it, and pair the headset again: `ml2-receiver pair`."


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Locks the folder against other receivers, and creates it if it is missing.

    Raises:
        KeysError: other users can write in the folder; or it, or a file in the `with` block, cannot
            be used.
    """
    try:
        with suppress(FileExistsError):
            make_private_folder(folder)
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            flock(descriptor, LOCK_EX)
            if os.fstat(descriptor).st_mode & _OTHERS_WRITE:
                raise KeysError(f"others can write in {folder}", hint=f"Run `chmod go-w {folder}`.")
            yield
        finally:
            os.close(descriptor)
    except OSError as error:
        place = error.filename or folder
        hint = file_hint(error, "choose another folder with --keys")
        raise KeysError(f"cannot use {place}: {error.strerror}", hint=hint) from error


def write(file: Path, data: bytes) -> None:
    """Replaces a file atomically; only the user can read it."""
    draft = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        write_private_file(draft, data)
        draft.replace(file)
    finally:
        draft.unlink(missing_ok=True)
