"""The command ml2-receiver."""

import argparse
import re
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from typing import Any, NoReturn

import shtab

from .errors import ReceiverError
from .generated.version import VERSION

__all__ = ["main"]

# Each is a module of commands/, in the order of --help.
_GROUP = "ml2_receiver.commands"
_EPILOG = """\
examples:
  ml2-receiver pair                   let a headset connect from now on
  ml2-receiver run                    receive, on port 7755
  ml2-receiver doctor                 find out what is wrong
  ml2-receiver run --help             what else a command takes
  eval "$(ml2-receiver --print-completion bash)"
"""
_UNKNOWN = re.compile(r"invalid choice: '(.*)' \(choose from (.*)\)$")


class _Parser(argparse.ArgumentParser):
    """Keeps the lines of examples, and guesses what a misspelt word was to be."""

    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **options)

    def error(self, message: str) -> NoReturn:
        if (unknown := _UNKNOWN.search(message)) is not None:
            choices = re.findall(r"[\w-]+", unknown[2])
            for close in get_close_matches(unknown[1], choices, 1):
                message += f"; did you mean {close}?"
        super().error(message)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one subcommand.

    Returns:
        0 when it did what it was asked to, 1 when what it looked at is not well, 2 when it could
        not, with the reason on stderr.
    """
    options = command_line().parse_args(arguments)
    try:
        exit_code: int = options.run(options)
    except ReceiverError as error:
        print(error, file=sys.stderr)
        if error.hint:
            print(f"hint: {error.hint}", file=sys.stderr)
        return 2
    return exit_code


def command_line() -> argparse.ArgumentParser:
    """All subcommands; parsing imports them, and none of ROS."""
    parser = _Parser(prog="ml2-receiver", description="Magic Leap 2 to ROS 2.", epilog=_EPILOG)
    parser.add_argument("--version", action="version", version=VERSION)
    shtab.add_argument_to(
        parser, "--print-completion", help="print what completes commands in this shell"
    )
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for entry_point in _commands():
        entry_point.load().add_parser(subparsers)
    return parser


def _commands() -> list[EntryPoint]:
    """Returns the subcommands of all installed packages: the driver's first, each by name.

    Raises:
        ReceiverError: the package has no metadata, so that it is not known which there are.
    """
    found = entry_points(group=_GROUP)
    if not found:
        raise ReceiverError(
            "no commands are installed: the metadata of ml2-receiver is missing. "
            "Start host_receiver/ml2-receiver in a clone, or `pip install ./host_receiver`"
        )
    return sorted(found, key=lambda it: (not it.module.startswith("ml2_receiver."), it.name))
