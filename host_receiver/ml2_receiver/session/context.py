"""The dependencies of the state machines, and the actions that they request."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from enum import Enum, auto

from ..errors import ProtocolError
from ..wire.json_body import JsonBody
from ..wire.kinds import Kind
from ..wire.messages import Error
from .connection import Connection
from .settings import ReceiverSettings
from .sink import Sink

_MESSAGE_CHARACTERS = 500


class Ending(Enum):
    """The ways to close a connection.

    DISCARD ends the output and discards input, so that the peer can read what it was sent. DRAIN
    ends both directions, but still receives the input that has arrived. Both take at most
    Limits.linger_s. ABORT ends everything at once.
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
    """The dependencies of the state machines.

    Attributes:
        settings: the receiver's settings.
        sink: takes topics, messages and events.
        act: performs an action; called in the order of the actions.
        clock: returns monotonic time in s.
        idle: returns the ids of streams that are not needed at present; the headset may pause them.
    """

    settings: ReceiverSettings
    sink: Sink
    act: Callable[[Action], None]
    clock: Callable[[], float]
    idle: Callable[[], Collection[str]] = tuple


def close(context: Context, connection: Connection, ending: Ending) -> None:
    """Closes a connection, unless it is closing already."""
    if not connection.is_closing:
        connection.is_closing = True
        context.act(Close(connection, ending))


def error_body(error: ProtocolError) -> Error:
    """Returns the fatal ERROR that reports `error` to the peer."""
    return Error(error.code, error.message[:_MESSAGE_CHARACTERS], fatal=True)
