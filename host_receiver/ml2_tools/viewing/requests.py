"""The messages of a browser. Each byte of them may be hostile."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from ml2_receiver.wire.json_body import Scalar

from .controls import SERVICES, Control

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


@dataclass(frozen=True)
class Change:
    """The receiver shall set these keys of a section; their values are legal one by one."""

    section: str
    values: Mapping[str, Scalar]


@dataclass(frozen=True)
class Call:
    """The receiver shall carry out a service."""

    service: str


type Request = Show | Seen | Change | Call


def parse_request(
    message: str | bytes, names: Collection[str], controls: Mapping[str, Control]
) -> Request:
    """Reads a message: one of
    `{"show": [STREAM, ...]}`, `{"seen": NAME}`, `{"set": SECTION, "to": {KEY: VALUE, ...}}` and
    `{"call": SERVICE}`.

    Args:
        names: the streams that the browser may ask for.
        controls: the sections that it may set.

    Raises:
        RequestError: it is another message, or names another stream, key, value or service.
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
        case {"set": str(section), "to": dict(values), **rest} if (
            not rest and section in controls and controls[section].takes(values)
        ):
            return Change(section, values)
        case {"call": str(service), **rest} if not rest and service in SERVICES:
            return Call(service)
    raise RequestError("expected a message of the page, with values that it offers")


def _are_of(streams: list[Any], names: Collection[str]) -> bool:
    return all(isinstance(it, str) and it in names for it in streams)
