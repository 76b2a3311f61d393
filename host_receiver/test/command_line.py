"""The parsers of a command and of all its subcommands; commands that end with an error."""

import argparse
from collections.abc import Iterator
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path

from ml2_receiver.cli import main

Words = tuple[str, ...]


def with_subcommands(
    words: Words, parser: argparse.ArgumentParser
) -> Iterator[tuple[Words, argparse.ArgumentParser]]:
    yield words, parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for word, subparser in action.choices.items():
                yield from with_subcommands((*words, word), subparser)


def refusal(*words: str | Path) -> str:
    """Runs a command, which has to end with exit code 2; returns what it says on standard error."""
    code: int | str | None
    with redirect_stderr(StringIO()) as said:
        try:
            code = main([str(word) for word in words])
        except SystemExit as ended:  # of argparse
            code = ended.code
    assert code == 2
    return said.getvalue()
