"""The surroundings of the state machines, and the actions that they return."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from enum import Enum, auto

from ..errors import ProtocolError
from ..wire.frame import Kind
from ..wire.json_body import JsonBody
from ..wire.messages import Error
from .connection import Connection
from .settings import ReceiverSettings
from .sink import Sink

_MESSAGE_CHARACTERS = 500


class Ending(Enum):
    """How a connection is closed.

    DISCARD ends the output and reads on without looking for at most Limits.linger_s, so that the
    peer can read what it was sent. DRAIN ends both directions, but what has arrived already is
    received, for as long at most. ABORT ends all at once.
    """

    DISCARD = auto()
    DRAIN = auto()
    ABORT = auto()


@dataclass(frozen=True)
class Send:
    """Write one frame."""

    connection: Connection
    kind: Kind
    body: JsonBody | None = None


@dataclass(frozen=True)
class Close:
    """Close a connection; closed() must follow."""

    connection: Connection
    ending: Ending


type Action = Send | Close


@dataclass(frozen=True)
class Context:
    """The surroundings of the state machines.

    Attributes:
        settings: the receiver's settings.
        sink: takes topics, messages and events.
        act: takes what is to be done, in order.
        clock: returns monotonic time in s.
        idle: returns the ids of streams that nobody needs at present; the headset may pause them.
    """

    settings: ReceiverSettings
    sink: Sink
    act: Callable[[Action], None]
    clock: Callable[[], float]
    idle: Callable[[], Collection[str]] = tuple


def close(context: Context, connection: Connection, ending: Ending) -> None:
    """Closes a connection once."""
    if not connection.is_closing:
        connection.is_closing = True
        context.act(Close(connection, ending))


def error_body(error: ProtocolError) -> Error:
    """The fatal ERROR that tells a peer of its fault."""
    return Error(error.code, error.message[:_MESSAGE_CHARACTERS], fatal=True)
