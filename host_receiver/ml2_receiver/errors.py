"""Everything the receiver raises for a reason outside its own code.

ReceiverError
├── ConfigError     the user's configuration file
└── TableError      the stream table, config/streams.yaml
"""

from collections.abc import Sequence
from dataclasses import dataclass


class ReceiverError(Exception):
    """The world is not as the receiver needs it; the message says what was expected and found."""


@dataclass(frozen=True)
class Problem:
    """One wrong place of a configuration file.

    `line` counts from 1, and is 0 when the whole file is meant. `key` is dotted as in the file,
    "world_left.update_rate", and empty when no key is to blame. `value` is the text found there.
    """

    line: int
    key: str
    value: str
    message: str

    def __str__(self) -> str:
        return f"{self.key}: {self.message}" if self.key else self.message


class ConfigError(ReceiverError):
    """A configuration file that cannot be used; `problems` has all that is wrong with it."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("; ".join(f"line {problem.line}: {problem}" for problem in self.problems))


class TableError(ReceiverError):
    """The stream table contradicts itself."""
