"""The exceptions that the receiver raises for reasons outside its own code.

ReceiverError
├── ConfigError       the user's configuration file
├── CalibrationError  a calibration of a camera or an inertial unit
├── TableError        the stream table, config/streams.yaml
├── ProtocolError     a peer broke the protocol
├── PublishError      ROS, Zenoh or the recording rejected a message
├── RosError          ROS 2 itself
├── ZenohError        the configuration of Zenoh
├── PackageError      an optional package is missing
├── LinkTestError     the link to the headset cannot be tested now
├── RecordingError    a recording that cannot be written or read
├── DiscoveryError    receivers cannot be searched for
├── KeysError         the folder with keys and paired devices
├── PairingError      no device was paired, or there is no such paired device
└── ListenError       the address to listen on
"""

import errno
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from .printable import printable


class ReceiverError(Exception):
    """The environment is not usable; the message says what happened and what was expected.

    Args:
        hint: what to do about it, in one sentence or two; empty if the message says enough. The
            command prints it on a line of its own.
    """

    def __init__(self, message: str, *, hint: str = "") -> None:
        super().__init__(printable(message, has_lines=True))
        self.hint = printable(hint, has_lines=True)

    def in_one_line(self) -> str:
        """Returns the message and the hint, for logs and for answers of services."""
        return printable(f"{self}. {self.hint}" if self.hint else str(self), has_lines=True)


NO_RECEIVER_HINT = (
    "Start `ml2-receiver run`, with the same ROS_DOMAIN_ID in both terminals. `ml2-receiver doctor`"
    " finds what is wrong."
)
_CONFIG_HINT = "`ml2-receiver config show` lists every section, key and legal value."
_ACCESS = "Give your user access to it"
_SPACE = "Free space on that disk"
_FILE_HINTS = {
    errno.EACCES: _ACCESS,
    errno.EPERM: _ACCESS,
    errno.ENOSPC: _SPACE,
    errno.EDQUOT: _SPACE,
}


def file_hint(error: OSError, otherwise: str) -> str:
    """Returns what to do about an unusable file or folder, with `otherwise` as alternative."""
    first = _FILE_HINTS.get(error.errno or 0)
    return f"{first}, or {otherwise}." if first else f"{otherwise[0].upper()}{otherwise[1:]}."


@dataclass(frozen=True)
class Problem:
    """One error in a configuration file.

    `line` counts from 1; 0 means the whole file. `key` is dotted as in the file,
    "world_left.update_rate", and empty if no key is wrong. `value` is the text found there.
    """

    line: int
    key: str
    value: str
    message: str

    def located_in(self, file: str) -> str:
        place = f"{file}:{self.line}" if self.line else file
        return ": ".join(filter(None, (place, self.key, self.message)))


class ConfigError(ReceiverError):
    """A configuration that cannot be used; `problems` lists every error in it.

    The message has one line per problem, "FILE:LINE: KEY: what was expected and found".
    """

    def __init__(self, problems: Sequence[Problem], file: str = "configuration") -> None:
        self.problems = tuple(problems)
        text = "\n".join(problem.located_in(file) for problem in problems)
        super().__init__(text, hint=_CONFIG_HINT if any(it.key for it in problems) else "")


class CalibrationError(ReceiverError):
    """A calibration of a camera or an inertial unit that cannot be used, made or saved."""


class TableError(ReceiverError):
    """The stream table contradicts itself."""


class ErrorCode(StrEnum):
    """The codes of fatal ERROR frames; PROTOCOL.md explains them."""

    VERSION = "version"
    BUSY = "busy"
    MALFORMED = "malformed"
    TOO_LARGE = "too_large"
    UNEXPECTED = "unexpected"
    TICKET = "ticket"
    CHANNEL = "channel"
    TIMEOUT = "timeout"
    PAIRING = "pairing"


class ProtocolError(ReceiverError):
    """A peer broke the protocol; fatal for its connection, and answered with an ERROR frame."""

    def __init__(self, code: ErrorCode, message: str) -> None:
        super().__init__(f"{code}: {message}")
        self.code = code
        self.message = message


class PublishError(ReceiverError):
    """ROS, Zenoh or the recording rejected a topic or a message."""


class RosError(ReceiverError):
    """ROS 2 is missing, or rejected its arguments."""


class ZenohError(ReceiverError):
    """Zenoh does not take its configuration, or an option of it is wrong."""


class PackageError(ReceiverError):
    """An optional package that a command needs is missing."""


class LinkTestError(ReceiverError):
    """No headset is connected, or its link cannot be tested now."""


class RecordingError(ReceiverError):
    """A recording cannot be written or read."""


class DiscoveryError(ReceiverError):
    """Receivers cannot be searched for by name."""


class KeysError(ReceiverError):
    """The folder with keys and paired devices cannot be used."""


class PairingError(ReceiverError):
    """No device was paired, or there is no such paired device."""


class ListenError(ReceiverError):
    """The receiver cannot listen on the address it was given."""
