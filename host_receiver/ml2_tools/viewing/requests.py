"""The messages of a browser, whose bytes may all be hostile, and what carries them out."""

import json
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from ml2_receiver.json_text import json_text
from ml2_receiver.wire.json_body import Scalar

from .section_forms import SectionForm

# Larger messages end the connection before they are read whole.
MOST_BYTES = 4096
SLOWEST, FASTEST = 0.25, 4


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
class Pixel:
    """The browser wants to know the value of a pixel of a stream's newest image in full size."""

    stream: str
    column: int
    row: int


@dataclass(frozen=True)
class Snapshot:
    """The browser wants a file of what the source delivers at present."""


@dataclass(frozen=True)
class Change:
    """The receiver shall set these keys of a section; their values are legal one by one."""

    section: str
    values: Mapping[str, Scalar]


@dataclass(frozen=True)
class Call:
    """The receiver shall carry out a service; with keys, save_config shall save these."""

    service: str
    keys: tuple[str, ...] = ()


@dataclass(frozen=True)
class Play:
    """The recording shall play, or stand still."""

    is_playing: bool


@dataclass(frozen=True)
class Seek:
    """The recording shall be shown from this time in s after its first message."""

    offset_s: float


@dataclass(frozen=True)
class Speed:
    """The recording shall be played so many times as fast."""

    rate: float


@dataclass(frozen=True)
class Pair:
    """A headset shall be paired, or the pairing shall end."""

    is_wanted: bool


# Requests that change the source of the view.
type BackendRequest = Change | Call | Pair | Play | Seek | Speed
type Request = Show | Seen | Pixel | Snapshot | BackendRequest


@dataclass(frozen=True)
class AllowedRequests:
    """The requests that a browser may make.

    Attributes:
        forms: the sections that it may set.
        services: the services that it may call.
        has_pairing: True if it may begin and end a pairing.
        length_s: the length of the recording; None without one.
    """

    forms: Mapping[str, SectionForm] = field(default_factory=dict)
    services: Collection[str] = ()
    has_pairing: bool = False
    length_s: float | None = None


def parse_request(
    message: str | bytes, names: Collection[str], allowed: AllowedRequests
) -> Request:
    """Reads a message: one of
    `{"show": [STREAM, ...]}`, `{"seen": NAME}`, `{"pixel": STREAM, "at": [COLUMN, ROW]}`,
    `{"snapshot": true}`,
    `{"set": SECTION, "to": {KEY: VALUE, ...}}`, `{"call": SERVICE}`,
    `{"call": "save_config", "keys": [SECTION.KEY, ...]}`, `{"pair": BOOL}`, `{"play": BOOL}`,
    `{"seek": SECONDS}` and `{"speed": RATE}`.

    Args:
        names: the streams that the browser may ask for.

    Raises:
        RequestError: it is another message, or asks for what is not offered.
    """
    try:
        found = json.loads(message) if isinstance(message, str) else None
    except (ValueError, RecursionError):
        found = None
    request: Request | None = _look(found, names) or _change(found, allowed)
    if request is None and allowed.length_s is not None:
        request = _move(found, allowed.length_s)
    if request is None:
        raise RequestError("expected a message of the page, with values that it offers")
    return request


def _look(found: Any, names: Collection[str]) -> Show | Seen | Pixel | Snapshot | None:
    match found:
        case {"show": list(streams), **rest} if not rest and _are_of(streams, names):
            return Show(frozenset(streams))
        case {"snapshot": True, **rest} if not rest:
            return Snapshot()
        case {"seen": str(name), **rest} if not rest:
            return Seen(name)
        case {"pixel": str(stream), "at": [int(column), int(row)], **rest} if not rest:
            is_place = stream in names and bool not in (type(column), type(row))
            return Pixel(stream, column, row) if is_place else None
    return None


def _change(found: Any, allowed: AllowedRequests) -> Change | Call | Pair | None:
    match found:
        case {"set": str(section), "to": dict(values), **rest} if (
            not rest and section in allowed.forms and allowed.forms[section].takes(values)
        ):
            return Change(section, values)
        case {"call": str(service), **rest} if not rest and service in allowed.services:
            return Call(service)
        case {"call": "save_config", "keys": list(keys), **rest} if not rest and _are_of(
            keys, [name for form in allowed.forms.values() for name in form.parameters()]
        ):
            return Call("save_config", tuple(keys))
        case {"pair": bool(is_wanted), **rest} if not rest and allowed.has_pairing:
            return Pair(is_wanted)
    return None


def _move(found: Any, length_s: float) -> Play | Seek | Speed | None:
    match found:
        case {"play": bool(is_playing), **rest} if not rest:
            return Play(is_playing)
        case {"seek": int() | float() as offset_s, **rest} if not rest:
            return Seek(float(offset_s)) if _is_within(offset_s, 0, length_s) else None
        case {"speed": int() | float() as rate, **rest} if not rest:
            return Speed(float(rate)) if _is_within(rate, SLOWEST, FASTEST) else None
    return None


def _is_within(value: float, least: float, most: float) -> bool:
    # True is a number, too.
    return not isinstance(value, bool) and least <= value <= most


def _are_of(found: list[Any], names: Collection[str]) -> bool:
    return all(isinstance(it, str) and it in names for it in found)


# The number of a message for browsers, from 1, and the message; 0 before the first.
type Newest = tuple[int, str]


class Outcome(NamedTuple):
    """The outcome of a request; `to` is the section, the service or the recording."""

    to: str
    is_done: bool
    text: str

    def message(self) -> str:
        """Returns the message for the browser."""
        return json_text({"type": "answer", **self._asdict()})


class Backend(Protocol):
    """Carries out requests of all browsers. Thread-safe.

    Attributes:
        allowed: the requests that it takes.
    """

    allowed: AllowedRequests

    def described(self) -> dict[str, Any]:
        """Returns what a page needs to know for requests, as keys of the message `hello`."""

    def sources(self) -> Iterable[tuple[str, Callable[[], Newest]]]:
        """Returns the kinds of messages about what is in force, each with a function for it."""

    def submit(self, request: BackendRequest, answered: Callable[[Outcome], None]) -> None:
        """Carries out a request that it allows, at once or later; then calls `answered`."""
