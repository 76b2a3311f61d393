"""Requests of browsers that change the source of a view."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, Protocol

from ml2_receiver.json_text import json_text

from .requests import Offer, Steer

# The number of a message for browsers, from 1, and the message; 0 before the first.
type Newest = tuple[int, str]


class Answer(NamedTuple):
    """The outcome of a request; `to` is the section, the service or the recording."""

    to: str
    is_done: bool
    text: str

    def message(self) -> str:
        """Returns the message for the browser."""
        return json_text({"type": "answer", **self._asdict()})


class Steered(Protocol):
    """Carries out requests of all browsers. Thread-safe.

    Attributes:
        offer: the requests that it takes.
    """

    offer: Offer

    def described(self) -> dict[str, Any]:
        """Returns what a page needs to know to steer, as keys of the message `hello`."""

    def sources(self) -> Iterable[tuple[str, Callable[[], Newest]]]:
        """Returns the kinds of messages about what is in force, each with a function for it."""

    def submit(self, request: Steer, answered: Callable[[Answer], None]) -> None:
        """Carries out a request that it offers, at once or later; then calls `answered`."""
