"""Where keys and paired devices are kept."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from fcntl import LOCK_EX, flock
from pathlib import Path

from ..errors import KeysError, file_hint

_OTHERS_WRITE = 0o022
REMOVE_HINT = "Remove it, and pair the headset again: `ml2-receiver pair`."


def default_folder() -> Path:
    """`ml2-sensors` in XDG_CONFIG_HOME, or ~/.config."""
    return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config", "ml2-sensors")


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Makes the folder if need be; nobody else changes it meanwhile.

    Raises:
        KeysError: something in it could not be read or written, here or inside.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        descriptor = os.open(folder, os.O_RDONLY)
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
    """All or nothing; only the user can read it."""
    draft = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        draft.touch(mode=0o600)
        draft.write_bytes(data)
        draft.replace(file)
    finally:
        draft.unlink(missing_ok=True)
