"""The parsers of a command and of all its subcommands."""

import argparse
from collections.abc import Iterator

Words = tuple[str, ...]


def with_subcommands(
    words: Words, parser: argparse.ArgumentParser
) -> Iterator[tuple[Words, argparse.ArgumentParser]]:
    yield words, parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for word, subparser in action.choices.items():
                yield from with_subcommands((*words, word), subparser)
