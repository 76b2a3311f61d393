"""Options that several commands have."""

import argparse
import math
import re
from pathlib import Path
from typing import Any

import shtab

type Subparsers = argparse._SubParsersAction[argparse.ArgumentParser]

_NAME = re.compile(r"([A-Za-z][A-Za-z0-9_]{0,39})?", re.ASCII)


def add_file(parser: argparse.ArgumentParser, *names: str, **options: Any) -> None:
    """Adds an argument that is a file, which shells then complete."""
    action = parser.add_argument(*names, type=Path, **options)
    action.complete = shtab.FILE  # type: ignore[attr-defined]


def add_name(parser: argparse.ArgumentParser) -> None:
    """--name of a command that watches a receiver."""
    parser.add_argument("--name", type=name, default="", help="of the receiver, where that has one")


def add_ros_args(parser: argparse.ArgumentParser) -> None:
    """--ros-args of a command that has a node: such as remappings, as the receiver has them."""
    parser.add_argument("--ros-args", nargs=argparse.REMAINDER, default=[], help=argparse.SUPPRESS)


def name(text: str) -> str:
    """Parses a part of topic names, or nothing, for argparse."""
    if not _NAME.fullmatch(text):
        raise argparse.ArgumentTypeError(
            f"expected at most 40 letters, digits and _, not beginning with a digit, found {text!r}"
        )
    return text


def port(text: str) -> int:
    """Parses a port, for argparse."""
    if not text.isdecimal() or not 1 <= int(text) <= 0xFFFF:
        raise argparse.ArgumentTypeError(f"expected a port from 1 to 65535, found {text!r}")
    return int(text)


def above_zero(text: str) -> float:
    """Parses a finite number above 0, for argparse."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0, found {text!r}")
    return number
