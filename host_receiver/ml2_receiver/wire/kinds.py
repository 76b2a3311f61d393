"""The kinds of frames and of connections."""

from dataclasses import dataclass
from enum import Enum, Flag, IntEnum, auto
from typing import Self

_KIB, _MIB = 1 << 10, 1 << 20
_UNKNOWN_KIND_BYTES = 64 * _KIB


class Side(Flag):
    """The sender of a frame."""

    DEVICE = auto()
    RECEIVER = auto()
    BOTH = DEVICE | RECEIVER


class LaneKind(Flag):
    """The kind of a connection; it is OPENING until HELLO or JOIN names the lane.

    SENSORS, IMAGE and BULK are the classes of the stream table, ROS and ROS_BULK carry openings. A
    connection to the port of
    `ml2-receiver pair` is PAIRING from beginning to end.
    """

    OPENING = auto()
    CONTROL = auto()
    TIME = auto()
    SENSORS = auto()
    IMAGE = auto()
    BULK = auto()
    LINK_TEST = auto()
    PAIRING = auto()
    ROS = auto()
    ROS_BULK = auto()
    DATA = SENSORS | IMAGE | BULK
    OTHER = TIME | DATA | LINK_TEST | ROS | ROS_BULK
    ANY = OPENING | CONTROL | OTHER | PAIRING


@dataclass(frozen=True)
class Lane:
    """A connection by its purpose; those that carry DATA are in the stream table.

    `is_urgent` says that nothing waits in front of it. No payload on it is longer than
    `max_payload_bytes`.
    """

    name: str
    kind: LaneKind
    is_urgent: bool = True
    max_payload_bytes: int = 0


OPENING = Lane("opening", LaneKind.OPENING)
CONTROL = Lane("control", LaneKind.CONTROL)
TIME = Lane("time", LaneKind.TIME)
LINK_TEST = Lane("link_test", LaneKind.LINK_TEST, is_urgent=False)
PAIRING = Lane("pairing", LaneKind.PAIRING)
ROS = Lane("ros", LaneKind.ROS, max_payload_bytes=64 * _KIB)
BULK_LANES = tuple(Lane(f"bulk_{n}", LaneKind.ROS_BULK, False, 16 * _MIB) for n in range(1, 5))
ROS_LANES = (ROS, *BULK_LANES)


class Body(Enum):
    """The content of the bytes after the header."""

    JSON = auto()
    PAYLOAD = auto()
    TIMES = auto()
    POSE = auto()
    NOISE = auto()
    EMPTY = auto()


class Kind(IntEnum):
    """The kinds of frames: number, sender, lanes, greatest length of the body, body.

    Payloads have a smaller bound on some lanes, see Lane.
    """

    sender: Side
    lanes: LaneKind
    max_length: int
    body: Body

    def __new__(
        cls, number: int, sender: Side, lanes: LaneKind, max_length: int, body: Body
    ) -> Self:
        kind = int.__new__(cls, number)
        kind._value_ = number
        kind.sender, kind.lanes, kind.max_length, kind.body = sender, lanes, max_length, body
        return kind

    HELLO = 1, Side.DEVICE, LaneKind.OPENING, 64 * _KIB, Body.JSON
    WELCOME = 2, Side.RECEIVER, LaneKind.CONTROL, 64 * _KIB, Body.JSON
    JOIN = 3, Side.DEVICE, LaneKind.OPENING, 4 * _KIB, Body.JSON
    JOINED = 4, Side.RECEIVER, LaneKind.OTHER, 4 * _KIB, Body.JSON
    CONFIGURE = 5, Side.RECEIVER, LaneKind.CONTROL, 64 * _KIB, Body.JSON
    CONFIGURED = 6, Side.DEVICE, LaneKind.CONTROL, 64 * _KIB, Body.JSON
    CHANNEL = 7, Side.DEVICE, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    CHANNEL_END = 8, Side.DEVICE, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    START = 9, Side.RECEIVER, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    DATA = 16, Side.DEVICE, LaneKind.DATA, 16 * _MIB, Body.PAYLOAD
    TIME_REQUEST = 32, Side.DEVICE, LaneKind.TIME, 8, Body.TIMES
    TIME_REPLY = 33, Side.RECEIVER, LaneKind.TIME, 24, Body.TIMES
    LINK_TEST = 40, Side.RECEIVER, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    FILLER = 41, Side.DEVICE, LaneKind.LINK_TEST, 64 * _KIB, Body.NOISE
    STATUS = 48, Side.DEVICE, LaneKind.CONTROL, 64 * _KIB, Body.JSON
    PING = 49, Side.BOTH, LaneKind.CONTROL, 0, Body.EMPTY
    PONG = 50, Side.BOTH, LaneKind.CONTROL, 0, Body.EMPTY
    ERROR = 51, Side.BOTH, LaneKind.ANY, 4 * _KIB, Body.JSON
    BYE = 52, Side.BOTH, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    EVENT = 53, Side.DEVICE, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    PAIR_CHALLENGE = 60, Side.RECEIVER, LaneKind.PAIRING, 4 * _KIB, Body.JSON
    PAIR = 61, Side.DEVICE, LaneKind.PAIRING, 16 * _KIB, Body.JSON
    PAIRED = 62, Side.RECEIVER, LaneKind.PAIRING, 4 * _KIB, Body.JSON
    OPEN = 96, Side.DEVICE, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    OPENED = 97, Side.RECEIVER, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    CLOSE = 98, Side.DEVICE, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    CLOSED = 99, Side.RECEIVER, LaneKind.CONTROL, 4 * _KIB, Body.JSON
    TAKEN = 112, Side.DEVICE, LaneKind.ROS_BULK, 0, Body.EMPTY
    MESSAGE = 128, Side.RECEIVER, LaneKind.ROS | LaneKind.ROS_BULK, 16 * _MIB, Body.PAYLOAD
    POSE = 129, Side.RECEIVER, LaneKind.ROS, 64, Body.POSE
    REQUEST = 130, Side.BOTH, LaneKind.ROS, 64 * _KIB, Body.PAYLOAD
    RESPONSE = 131, Side.BOTH, LaneKind.ROS, 64 * _KIB, Body.PAYLOAD
    FAILURE = 132, Side.BOTH, LaneKind.ROS, 4 * _KIB, Body.JSON

    @property
    def is_of_openings(self) -> bool:
        """True if only sessions with `ros` in WELCOME know the kind."""
        return self >= Kind.OPEN


KIND_BY_NUMBER = {int(kind): kind for kind in Kind}


def max_bytes(kind: Kind | None) -> int:
    """Returns the greatest length of a body in bytes; None is any unknown kind."""
    return _UNKNOWN_KIND_BYTES if kind is None else kind.max_length


def kind_name(kind: int) -> str:
    """Returns the name of a kind, or "kind NUMBER" if it is unknown."""
    return KIND_BY_NUMBER[kind].name if kind in KIND_BY_NUMBER else f"kind {kind}"
