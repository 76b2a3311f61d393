"""The subscriptions that fill the view."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto


class Kind(Enum):
    """The use of messages: TRANSFORMS, EVENTS and STATIC need each one, others only the newest."""

    IMAGE = auto()
    SENSOR = auto()
    TRANSFORMS = auto()
    EVENTS = auto()
    LATCHED = auto()
    STATIC = auto()


@dataclass(frozen=True, eq=False)
class Subscription:
    """A part of the view that takes the messages of a topic.

    `take` gets the CDR of each message, and when it came in s on the clock of the source.
    """

    topic: str
    type: str
    kind: Kind
    take: Callable[[bytes, float], None]
