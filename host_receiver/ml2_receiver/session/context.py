"""What the state machines stand in, and what they want done."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto

from ..errors import ProtocolError
from ..table.stream_table import StreamTable
from ..wire.frame import Kind
from ..wire.json_body import JsonBody
from ..wire.messages import Error
from .connection import Connection
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
class Limits:
    """The receiver's limits, from PROTOCOL.md; tests make some tighter, others looser."""

    handshake_s: float = 5.0
    ping_s: float = 0.5
    dead_s: float = 2.0
    linger_s: float = 1.0
    unfinished_connections: int = 16
    connections_per_address: int = 64
    failed_attempts: int = 10
    failed_attempts_per_s: float = 1.0
    shared_address_s: float = 24 * 3600.0
    shared_failed_attempts: int = 100
    shared_failed_attempts_per_s: float = 50.0


@dataclass(frozen=True)
class Context:
    """What the state machines stand in.

    `act` takes what is to be done, in order; `clock` is monotonic time in s; `idle` has the ids of
    streams that nobody needs at present, which the headset may pause; `frame_prefix` is what the
    headset's frame ids are to begin with; `withheld` has the streams that no headset is asked for,
    whoever wants them, and why.
    """

    table: StreamTable
    sink: Sink
    limits: Limits
    act: Callable[[Action], None]
    clock: Callable[[], float]
    name: str
    software: str
    idle: Callable[[], Collection[str]] = tuple
    frame_prefix: str = ""
    withheld: Mapping[str, str] = field(default_factory=dict)


def close(context: Context, connection: Connection, ending: Ending) -> None:
    """Closes a connection once."""
    if not connection.is_closing:
        connection.is_closing = True
        context.act(Close(connection, ending))


def error_body(error: ProtocolError) -> Error:
    """The fatal ERROR that tells a peer of its fault."""
    return Error(error.code, error.message[:_MESSAGE_CHARACTERS], fatal=True)
