"""The messages of a browser. Each byte of them may be hostile."""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

# Larger messages end the connection before they are read whole.
MOST_BYTES = 4096


class RequestError(Exception):
    """A browser's message is none of those that there are; fatal for its connection."""


@dataclass(frozen=True)
class Show:
    """The browser shows the images of these streams from now on, and of no others."""

    streams: frozenset[str]


@dataclass(frozen=True)
class Seen:
    """The browser has shown one message of this name: a stream, or a kind of text message."""

    name: str


def parse_request(message: str | bytes, names: Collection[str]) -> Show | Seen:
    """Reads a message: `{"show": [STREAM, ...]}` or `{"seen": NAME}`.

    Args:
        names: the streams that the browser may ask for.

    Raises:
        RequestError: it is another message, or names another stream.
    """
    try:
        found = json.loads(message) if isinstance(message, str) else None
    except (ValueError, RecursionError):
        found = None
    match found:
        case {"show": list(streams), **rest} if not rest and _are_of(streams, names):
            return Show(frozenset(streams))
        case {"seen": str(name), **rest} if not rest:
            return Seen(name)
    raise RequestError("expected the streams to show, or the name of a seen message")


def _are_of(streams: list[Any], names: Collection[str]) -> bool:
    return all(isinstance(it, str) and it in names for it in streams)
