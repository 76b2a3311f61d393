"""The interface of what carries out openings, the counterpart of Sink: ROS, later Zenoh."""

from typing import Protocol

from ..configuration.app_rules import AppRules
from ..printable import printable
from ..wire.frame import Frame
from ..wire.opening_bodies import Open, Opened
from .downlink import Downlink

_MOST_CHARACTERS = 500


class Graph(Protocol):
    """Carries out the openings of apps. Thread-safe. No method blocks."""

    @property
    def rules(self) -> AppRules:
        """The current rules for apps."""

    def resolve(self, wanted: Open) -> str:
        """Returns the full name that the app means; raises ValueError if it is no name."""

    def open(self, wanted: Open, name: str, downlink: Downlink) -> Opened:
        """Opens the resolved name, and returns the answer; messages go into a queue."""

    def close(self, id: int) -> None:
        """Ends an opening; nothing of it is sent any more."""

    def received(self, frame: Frame) -> None:
        """Takes a frame of an opening, whose body is valid during the call alone."""


def refused(wanted: Open, reason: str, code: str | None = None) -> Opened:
    """Returns the answer that refuses an opening; PROTOCOL.md has the codes."""
    return Opened(wanted.id, "refused", reason=in_words(reason), code=code)


def in_words(reason: str) -> str:
    """Returns a reason as OPENED and CLOSED have it: it may quote the app or another node."""
    return printable(reason, _MOST_CHARACTERS)
