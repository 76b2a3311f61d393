"""Options that several commands have."""

import argparse
import math
import re
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import shtab

from ..table.reader import load_table
from ..table.stream_table import Key
from ..wire.json_body import Scalar

# The shell functions that complete an argument, by the kind of its values.
TOPICS, KEYS, VALUES, STREAMS = "_ml2_topics", "_ml2_keys", "_ml2_values", "_ml2_streams"

type Subparsers = argparse._SubParsersAction[argparse.ArgumentParser]

_NAME = re.compile(r"([A-Za-z][A-Za-z0-9_]{0,39})?", re.ASCII)


def add_file(parser: argparse.ArgumentParser, *names: str, **options: Any) -> None:
    """Adds an argument that is a file, which shells then complete."""
    action = parser.add_argument(*names, type=Path, **options)
    action.complete = shtab.FILE  # type: ignore[attr-defined]


def complete(action: argparse.Action, words: str) -> None:
    """Has shells complete an argument with TOPICS, KEYS, VALUES or STREAMS."""
    action.complete = {"bash": words, "zsh": words}  # type: ignore[attr-defined]


def completion_functions() -> dict[str, str]:
    """Returns the functions by shell: what the stream table has, since shells cannot wait for ROS.

    bash takes what follows `=` for a word of its own.
    """
    completed = _completed()
    words = {name: shlex.quote(" ".join(it)) for name, it in completed.items()}
    bash = [f'{name}() {{ compgen -W {it} -- "$1"; }}' for name, it in words.items()]
    typed = '''local typed="${COMP_LINE:0:COMP_POINT}"; typed="${typed##* }"'''
    cut = '"$([[ $typed = *=* ]] && echo "s/^[^=]*=//")"'
    bash.append(f'{VALUES}() {{ {typed}; compgen -W {words[VALUES]} -- "$typed" | sed {cut}; }}')
    zsh = [f"{name}() {{ compadd -- {shlex.join(it)}; }}" for name, it in completed.items()]
    return {"bash": "\n".join(bash), "zsh": "\n".join(zsh)}


def _completed() -> dict[str, list[str]]:
    table = load_table()
    topics = [it for stream in table.streams.values() for it in stream.topics]
    sections = table.sections.values()
    keys = {f"{it.id}.{key.name}": key for it in sections for key in it.keys.values()}
    modes = [
        f"{it.id}.mode={width}x{height}@{rate}"
        for it in sections
        for mode in it.modes
        for width, height in mode.resolutions
        for rate in mode.rates
    ]
    values = [f"{name}={it}" for name, key in keys.items() for it in _likely(key)]
    return {
        TOPICS: [it.name for it in topics] + [it.name for it in table.receiver_topics],
        KEYS: [*keys],
        VALUES: [*values, *dict.fromkeys(modes)],
        STREAMS: [*table.streams],
    }


def _likely(key: Key) -> Iterable[Scalar]:
    return ("true", "false") if key.type == "bool" else key.allowed or (key.default,)


def add_name(parser: argparse.ArgumentParser) -> None:
    """--name of a command that watches a receiver."""
    parser.add_argument("--name", type=name, default="", help="of the receiver, where that has one")


def add_ros_args(parser: argparse.ArgumentParser) -> None:
    """--ros-args of a command that has a node: such as remappings, as the receiver has them."""
    parser.add_argument("--ros-args", nargs=argparse.REMAINDER, default=[], help=argparse.SUPPRESS)


def add_receiver(parser: argparse.ArgumentParser) -> None:
    """The options of a command that watches a receiver with a node."""
    add_name(parser)
    add_ros_args(parser)


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
