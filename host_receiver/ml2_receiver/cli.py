"""The command ml2-receiver."""

import argparse
import errno
import io
import os
import re
import select
import signal
import sys
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn, TextIO

import shtab

from .commands.options import completion_functions
from .commands.ros_start import ros_args_of
from .commands.stopping import INTERRUPTED, heed_interrupts, run_interruptible
from .errors import ReceiverError
from .generated.version import VERSION

__all__ = ["main"]

# The entry points of the subcommands; each is a module of commands/.
_GROUP = "ml2_receiver.commands"
_HELP_COLUMN = 14
# The headings of the help. A subcommand of another package is among the others.
_HEADINGS = {
    "everyday": ("run", "view", "topics", "set", "call"),
    "look": ("echo", "products", "rviz", "compat"),
    "record": ("record", "play", "inspect", "export", "evaluate"),
    "set up": ("pair", "unpair", "headset", "config", "calibrate", "messages"),
    "diagnose": ("doctor", "devices", "latency"),
}
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

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuses what this parser does not know itself: the one above would show its own usage."""
        own = list(takewhile(lambda it: it not in ("--", "--ros-args"), args))
        if self._subparsers is not None:
            own = list(takewhile(lambda it: it.startswith("-"), own))
        for name in (it.partition("=")[0] for it in own if it.startswith("--")):
            if not any(option.startswith(name) for option in self._option_string_actions):
                close = get_close_matches(name, self._option_string_actions, 1)
                meant = f"; did you mean {close[0]}?" if close else ""
                self.error(f"unrecognized option: {name}{meant}")
        parsed, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return parsed, unknown


class _WholeParser(_Parser):
    """The parser of all subcommands, which its help lists under headings."""

    def format_help(self) -> str:
        formatter = argparse.RawDescriptionHelpFormatter(self.prog, max_help_position=_HELP_COLUMN)
        formatter.add_usage(self.usage, self._actions, self._mutually_exclusive_groups)
        formatter.add_text(self.description)
        (subcommands,) = (it for it in self._actions if isinstance(it, argparse._SubParsersAction))
        left = {it.dest: it for it in subcommands._get_subactions()}
        for heading, names in _HEADINGS.items():
            _add_section(formatter, heading, [left.pop(it) for it in names if it in left])
        _add_section(formatter, "others", left.values())
        _add_section(formatter, "options", self._get_optional_actions())
        formatter.add_text(self.epilog)
        return formatter.format_help()


def _add_section(
    formatter: argparse.HelpFormatter, heading: str, actions: Iterable[argparse.Action]
) -> None:
    formatter.start_section(heading)
    formatter.add_arguments(actions)
    formatter.end_section()


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one subcommand.

    Args:
        arguments: None for those of this process, which Ctrl-C then ends soon, whatever hangs.

    Returns:
        0 if the command succeeded, 1 if it found a problem in what it checked, 2 if it failed, with
        the reason on stderr, as when the output cannot be written; 130 after Ctrl-C, and 141 if
        nobody reads the output any more, as of programs that end by these signals.
    """
    heed_interrupts()
    _open_missing_outputs()
    if arguments is None:
        return run_interruptible(_run_own)
    try:
        return _run_checked(arguments)
    except KeyboardInterrupt:
        return INTERRUPTED


def _run_own() -> int:
    _lose_unwritable_errors()
    return _run_checked(sys.argv[1:])


def _run_checked(arguments: Sequence[str]) -> int:
    """Works as _run(), and has exit codes for an output that cannot be written."""
    try:
        return _run(arguments)
    except BrokenPipeError:
        if not _is_unread(sys.stdout):
            raise
        _leave_unwritten(sys.stdout)
        return 128 + signal.SIGPIPE
    except OSError as error:
        if error.errno != errno.ENOSPC or error.filename is not None:
            raise
        _leave_unwritten(sys.stdout)
        print(f"the output cannot be written: {error.strerror}", file=sys.stderr)
        return 2


def _run(arguments: Sequence[str]) -> int:
    try:
        parser = command_line(arguments)
        if not arguments:
            parser.print_help()
            return 2
        options = parser.parse_args(arguments)
        with ros_args_of(options):
            exit_code: int = options.run(options)
        return exit_code
    except ReceiverError as error:
        print(error, file=sys.stderr)
        if error.hint:
            print(f"hint: {error.hint}", file=sys.stderr)
        return 2
    finally:
        sys.stdout.flush()


def _open_missing_outputs() -> None:
    """Whoever starts a process may have closed them; a file opened later would become one."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w"))  # noqa: SIM115, for good


class _LossyFile(io.FileIO):
    """A file that drops what it cannot write."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data) or len(data)  # 0 and None: there is no room now
        except OSError:
            return len(data)


def _lose_unwritable_errors() -> None:
    """Lets the command go on when nobody reads stderr any more, or its disk is full.

    A shell that starts without stderr may have opened its own script there, to read it.
    """
    file = io.BufferedWriter(_LossyFile(sys.stderr.fileno(), "w", closefd=False))
    errors, encoding = sys.stderr.errors, sys.stderr.encoding
    sys.stderr = io.TextIOWrapper(file, encoding, errors, line_buffering=True)


def _leave_unwritten(output: TextIO) -> None:
    """Keeps Python from failing again when it flushes what is left."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), output.fileno())


def _is_unread(output: TextIO) -> bool:
    """Returns True for a pipe that nobody reads any more."""
    poll = select.poll()
    poll.register(output, select.POLLERR)
    return bool(poll.poll(0))


def command_line(arguments: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Returns the parser for `arguments`: of the subcommand that they begin with, else of all.

    It imports the modules of these subcommands, but not ROS.
    """
    parser = _WholeParser(
        prog="ml2-receiver",
        usage="%(prog)s [options] COMMAND ...",
        description="Magic Leap 2 to ROS 2.",
        epilog=_EPILOG,
    )
    parser.add_argument("--version", action="version", version=VERSION)
    is_completion = any(it.startswith("--print") for it in arguments)
    shtab.add_argument_to(
        parser,
        "--print-completion",
        help="print the completion script for this shell",
        preamble=completion_functions() if is_completion else {},
    )
    subparsers = parser.add_subparsers(
        required=True, metavar="COMMAND", prog=parser.prog, parser_class=_Parser
    )
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
