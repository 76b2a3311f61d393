"""Reads the pairing URI of a command: from standard input, a file, or its arguments.

Other users of the machine can read the arguments of a command, and the shell keeps them.
"""

import sys
from pathlib import Path

from ..configuration.whole_file import read_file
from ..errors import PairingError, file_hint
from .uri import PairingUri

STANDARD_INPUT = "-"
_MAX_BYTES = 4096
_HINT = "`ml2-receiver pair` prints one on its first line."


def uri_of(source: str) -> PairingUri:
    """Returns the URI on the first line of `source`; waits for that of standard input.

    Args:
        source: "-" for standard input, the name of a file, or the URI itself.

    Raises:
        PairingError: there is no URI. The message does not repeat what was found, as it may
            contain a token.
    """
    if source == STANDARD_INPUT:
        return _parsed(_typed_line(), "on standard input")
    if "://" in source or "token=" in source:  # the error about a file would repeat it
        return PairingUri.parse(source)
    return _parsed(_first_line(Path(source)), f"in {source}")


def _typed_line() -> str:
    if sys.stdin is None:  # closed by whoever started this
        return ""
    if sys.stdin.isatty():
        print("paste the URI that `ml2-receiver pair` shows:", file=sys.stderr, flush=True)
    try:
        return sys.stdin.readline(_MAX_BYTES)
    except UnicodeDecodeError:
        return "no text"


def _first_line(file: Path) -> str:
    try:
        data = read_file(file, _MAX_BYTES)
    except OSError as error:
        hint = file_hint(error, f"give the URI on standard input, with `{STANDARD_INPUT}`")
        raise PairingError(f"{file} cannot be read: {error.strerror}", hint=hint) from error
    if len(data) > _MAX_BYTES:
        raise PairingError(f"{file}: expected at most {_MAX_BYTES} bytes", hint=_HINT)
    return data.decode("ascii", "replace").partition("\n")[0]


def _parsed(line: str, place: str) -> PairingUri:
    try:
        return PairingUri.parse(line.strip())
    except PairingError:
        found = "another line" if line.strip() else "nothing"
        message = f"expected ml2s://HOST:PORT?fp=...&token=... {place}, found {found}"
        raise PairingError(message, hint=_HINT) from None
