"""The command ml2-receiver."""

import argparse
import re
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from typing import Any, NoReturn

import shtab

from .commands.stopping import heed_interrupts
from .errors import ReceiverError
from .generated.version import VERSION

__all__ = ["main"]

# The entry points of the subcommands; each is a module of commands/.
_GROUP = "ml2_receiver.commands"
_EPILOG = """\
examples:
  ml2-receiver pair                   pair a headset
  ml2-receiver run                    receive on port 7755
  ml2-receiver doctor                 find problems
  ml2-receiver run --help             list the options of a command
  eval "$(ml2-receiver --print-completion bash)"
"""
_UNKNOWN = re.compile(r"invalid choice: '(.*)' \(choose from (.*)\)$")


class _Parser(argparse.ArgumentParser):
    """A parser that keeps the line breaks of examples and suggests corrections of typos."""

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
        0 if the command succeeded, 1 if it found a problem in what it checked, 2 if it failed, with
        the reason on stderr.
    """
    heed_interrupts()
    arguments = sys.argv[1:] if arguments is None else arguments
    options = command_line(arguments).parse_args(arguments)
    try:
        exit_code: int = options.run(options)
    except ReceiverError as error:
        print(error, file=sys.stderr)
        if error.hint:
            print(f"hint: {error.hint}", file=sys.stderr)
        return 2
    return exit_code


def command_line(arguments: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Returns the parser for `arguments`: of the subcommand that they begin with, else of all.

    It imports the modules of these subcommands, but not ROS.
    """
    parser = _Parser(prog="ml2-receiver", description="Magic Leap 2 to ROS 2.", epilog=_EPILOG)
    parser.add_argument("--version", action="version", version=VERSION)
    shtab.add_argument_to(
        parser, "--print-completion", help="print the completion script for this shell"
    )
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    commands = _commands()
    named = [it for it in commands if it.name in arguments[:1]]
    for entry_point in named or commands:
        entry_point.load().add_parser(subparsers)
    return parser


def _commands() -> list[EntryPoint]:
    """Returns the subcommands of all installed packages: the driver's first, each by name.

    Raises:
        ReceiverError: the package has no metadata, which lists the subcommands.
    """
    found = entry_points(group=_GROUP)
    if not found:
        raise ReceiverError(
            "no commands are installed: the metadata of ml2-receiver is missing. "
            "Start host_receiver/ml2-receiver in a clone, or `pip install ./host_receiver`"
        )
    return sorted(found, key=lambda it: (not it.module.startswith("ml2_receiver."), it.name))
