"""The options and outputs that all commands share which read a recording."""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from ml2_receiver.errors import RecordingError
from ml2_receiver.printable import printable

from ..bags.bag_reader import Bag

_HEADSET = (
    "of a recording with several: the prefix of its topics, or the name of its receiver or device"
)


def add_headset(parser: argparse.ArgumentParser) -> None:
    """--headset of a command that reads a recording."""
    parser.add_argument("--headset", metavar="NAME", help=_HEADSET)


def check_headset(headset: str | None) -> None:
    """Checks the option of a command that reads no recording.

    Raises:
        RecordingError: it is there.
    """
    if headset is not None:
        raise RecordingError(
            "--headset is of a recording, but there is none",
            hint="Name the recording, or leave out --headset.",
        )


def say_left_out(left_out: Iterable[str]) -> None:
    """Says on stderr what was not read."""
    for words in left_out:
        print(f"left out: {printable(words)}", file=sys.stderr, flush=True)


def say_apart(apart: Iterable[str]) -> None:
    """Says on stderr that a recording may be several ones."""
    for words in apart:
        print(f"note: {printable(words)}", file=sys.stderr, flush=True)


@contextmanager
def progress(bag: Bag, label: str) -> Iterator[Callable[[int], None]]:
    """Shows a bar on stderr; yields a function to call with the length of each payload."""
    columns = TextColumn(label), BarColumn(), TaskProgressColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=bag.size_bytes)
        yield lambda size: bar.advance(task, size)
