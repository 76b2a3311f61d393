"""The actions that the state machines request."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto

from ..errors import ProtocolError
from ..table.stream_table import Topic
from ..wire.json_body import JsonBody
from ..wire.kinds import Kind
from ..wire.messages import Error
from .connection import Connection, Route
from .event_limit import Cause
from .report import Report
from .sink import Applied
from .will import Will

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
    """Close a connection; Host.closed() must follow."""

    connection: Connection
    ending: Ending


@dataclass(frozen=True)
class Open:
    """Set `route.publish` to what opens the topic, or call Host.topic_refused()."""

    control: Connection
    channel: int
    topic: Topic
    route: Route


@dataclass(frozen=True)
class EndWill:
    """End a channel with its will."""

    will: Will


@dataclass(frozen=True)
class SessionEnded:
    """Tell the sink that a session has ended, with its last report."""

    report: Report


@dataclass(frozen=True)
class Log:
    """Log a line for the user."""

    text: str
    cause: Cause


type Action = Send | Close | Open | EndWill | Applied | SessionEnded | Log
type Act = Callable[[Action], None]


def close(act: Act, connection: Connection, ending: Ending) -> None:
    """Requests to close a connection, unless it is closing already."""
    if not connection.is_closing:
        connection.is_closing = True
        act(Close(connection, ending))


def error_body(error: ProtocolError) -> Error:
    """Returns the fatal ERROR that reports `error` to the peer."""
    return Error(error.code, error.message[:_MESSAGE_CHARACTERS], fatal=True)
