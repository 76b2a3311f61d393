"""Says how to install an optional package that a command needs."""

from collections.abc import Iterator
from contextlib import contextmanager

from ml2_receiver.errors import PackageError

_DEBIAN = {"cv2": "python3-opencv", "matplotlib": "python3-matplotlib", "scipy": "python3-scipy"}


@contextmanager
def optional_packages(*names: str, command: str, pip: str) -> Iterator[None]:
    """Guards imports that need optional packages.

    Args:
        names: the packages, as Python imports them.
        command: the command that needs them.
        pip: the command that installs them, in the clone.

    Raises:
        PackageError: one of them is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        if missing not in names:
            raise
        in_clone = f"in the clone `{pip}`"
        debian = _DEBIAN.get(missing)
        raise PackageError(
            f"`{command}` needs {missing}, which is not installed",
            hint=f"Run `sudo apt install {debian}`, or {in_clone}."
            if debian
            else f"Run {in_clone}.",
        ) from error
