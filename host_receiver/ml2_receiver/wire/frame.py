"""Frames: the 32-byte header, the kinds, and a parser without I/O."""

import struct
from collections.abc import Iterator
from enum import Enum, Flag, IntEnum, auto
from typing import NamedTuple, Self

from ..errors import ErrorCode, ProtocolError

MAGIC = 0x324D
VERSION = 1
CDR_ENCAPSULATION = b"\x00\x01\x00\x00"

# The first two bytes of a TLS connection: a handshake record, major version 3.
_TLS_MAGIC = 0x0316
_LAYOUT = struct.Struct("<HBBHHIIqq")
HEADER_BYTES = _LAYOUT.size
_KIB, _MIB = 1 << 10, 1 << 20
_UNKNOWN_KIND_BYTES = 64 * _KIB
_SENSORS_DATA_BYTES = 64 * _KIB
# The body buffer grows at most this far ahead of the bytes that have arrived.
_GROWTH_BYTES = _MIB
_ZEROS = memoryview(bytes(_GROWTH_BYTES))


class Side(Flag):
    """The sender of a frame."""

    DEVICE = auto()
    RECEIVER = auto()
    BOTH = DEVICE | RECEIVER


class LaneKind(Flag):
    """The kind of a connection; it is OPENING until HELLO or JOIN names the lane.

    A connection to the port of `ml2-receiver pair` is PAIRING from beginning to end.
    """

    OPENING = auto()
    CONTROL = auto()
    TIME = auto()
    SENSORS = auto()
    IMAGE = auto()
    LINK_TEST = auto()
    PAIRING = auto()
    OTHER = TIME | SENSORS | IMAGE | LINK_TEST
    ANY = OPENING | CONTROL | OTHER | PAIRING

    @staticmethod
    def of(lane: str) -> "LaneKind":
        """Returns the kind of the lane with this name; an image lane has its stream's id."""
        return _LANE_KINDS.get(lane, LaneKind.IMAGE)


_LANE_KINDS = {
    "control": LaneKind.CONTROL,
    "time": LaneKind.TIME,
    "sensors": LaneKind.SENSORS,
    "link_test": LaneKind.LINK_TEST,
    "pairing": LaneKind.PAIRING,
}


class Body(Enum):
    """The content of the bytes after the header."""

    JSON = auto()
    PAYLOAD = auto()
    TIMES = auto()
    NOISE = auto()
    EMPTY = auto()


class Kind(IntEnum):
    """The kinds of frames: number, sender, lanes, greatest length of the body, body.

    DATA has a smaller bound on the sensors lane, see max_data_bytes().
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
    DATA = 16, Side.DEVICE, LaneKind.SENSORS | LaneKind.IMAGE, 16 * _MIB, Body.PAYLOAD
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


_KINDS = {int(kind): kind for kind in Kind}
_FIXED = {int(kind) for kind in Kind if kind.body is Body.TIMES}


class Header(NamedTuple):
    """The fields of PROTOCOL.md's frame header; times are ROS time in ns."""

    magic: int
    version: int
    kind: int
    flags: int
    channel: int
    sequence: int
    length: int
    capture_ns: int
    send_ns: int


class Frame(NamedTuple):
    """A complete frame. `payload` is the parser's own buffer, see FrameParser."""

    header: Header
    payload: bytearray


def max_data_bytes(lane: LaneKind) -> int:
    """Returns the greatest payload in bytes on a lane that carries DATA."""
    return _SENSORS_DATA_BYTES if lane is LaneKind.SENSORS else Kind.DATA.max_length


def encode_frame(
    kind: Kind,
    body: bytes = b"",
    *,
    channel: int = 0,
    sequence: int = 0,
    capture_ns: int = 0,
    send_ns: int = 0,
) -> bytes:
    """Returns the bytes of a frame.

    Raises:
        ValueError: the body is longer than the kind allows.
    """
    if len(body) > kind.max_length:
        raise ValueError(f"{kind.name} takes {kind.max_length} B, got {len(body)}")
    fields = (MAGIC, VERSION, kind, 0, channel, sequence, len(body), capture_ns, send_ns)
    return _LAYOUT.pack(*fields) + body


class FrameParser:
    """A parser that turns the bytes of one connection into frames.

    It is used like asyncio.BufferedProtocol: receive into get_buffer(), then pass the number of
    received bytes to buffer_updated(), which returns a completed frame or None. Where frames are
    small, receive many at once and pass the bytes to feed() instead. A frame's payload
    is one bytearray that is reused: it has exactly the body's length and is valid until the next
    get_buffer(). Its memory grows with the bytes that arrived, not to the length in the header, and
    is kept for the next frame.

    Not thread-safe. The parser cannot be used after a ProtocolError.

    Args:
        sender: the side that sends these bytes.
        lane: the kind of the connection; set the attribute when HELLO or JOIN names the lane.
    """

    def __init__(self, sender: Side, lane: LaneKind = LaneKind.OPENING) -> None:
        self._sender = sender
        self.lane = lane
        self._head = bytearray(HEADER_BYTES)
        self._body = bytearray()
        self._header: Header | None = None
        self._view = memoryview(b"")
        self._filled = 0

    @property
    def lane(self) -> LaneKind:
        return self._lane

    @lane.setter
    def lane(self, lane: LaneKind) -> None:
        self._lane = lane
        self._limits = {
            int(kind): kind.max_length
            for kind in Kind
            if kind.sender & self._sender and kind.lanes & lane
        }
        if Kind.DATA in self._limits:
            self._limits[Kind.DATA] = max_data_bytes(lane)

    @property
    def is_between_frames(self) -> bool:
        """True if the bytes so far end with a complete frame."""
        return self._header is None and self._filled == 0

    def feed(self, data: memoryview) -> Iterator[Frame]:
        """Yields the frames that `data` completes; each is valid until the next one.

        Raises:
            ProtocolError: as buffer_updated().
        """
        while data:
            target = self.get_buffer()
            count = min(len(target), len(data))
            target[:count] = data[:count]
            data = data[count:]
            if (frame := self.buffer_updated(count)) is not None:
                yield frame

    def get_buffer(self) -> memoryview:
        """Returns the buffer for the next bytes, never empty; valid until buffer_updated()."""
        target = self._head if self._header is None else self._body
        self._view = memoryview(target)[self._filled :]
        return self._view

    def buffer_updated(self, count: int) -> Frame | None:
        """Takes `count` bytes from the last buffer; returns the frame they complete, or None.

        Raises:
            ProtocolError: `version`, `malformed`, `unexpected` or `too_large`.
        """
        self._view.release()
        self._filled += count
        header = self._header
        if header is None:
            if self._filled < HEADER_BYTES:
                return None
            header = self._header = self._checked(Header._make(_LAYOUT.unpack(self._head)))
            self._filled = 0
            self._fit(header.length)
        if self._filled < header.length:
            if self._filled == len(self._body):
                self._grow(header.length)
            return None
        self._header, self._filled = None, 0
        return Frame(header, self._body)

    def _checked(self, header: Header) -> Header:
        if header.magic == _TLS_MAGIC:
            raise ProtocolError(
                ErrorCode.MALFORMED, "expected a frame, found TLS: only this side has --insecure"
            )
        if header.magic != MAGIC:
            raise ProtocolError(
                ErrorCode.MALFORMED, f"expected magic {MAGIC:#06x}, found {header.magic:#06x}"
            )
        if header.version != VERSION:
            raise ProtocolError(
                ErrorCode.VERSION, f"expected version {VERSION}, found {header.version}"
            )
        limit = self._limits.get(header.kind)
        bound = _length_bound(header.kind) if limit is None else limit
        if header.length > bound:
            raise ProtocolError(
                ErrorCode.TOO_LARGE,
                f"{kind_name(header.kind)} takes {bound} B, its header says {header.length}",
            )
        if limit is None and (header.kind in _KINDS or self._lane is LaneKind.OPENING):
            lane = (
                "a new connection" if self._lane is LaneKind.OPENING else f"lane {self._lane.name}"
            )
            raise ProtocolError(ErrorCode.UNEXPECTED, f"{kind_name(header.kind)} on {lane}")
        if header.length < bound and header.kind in _FIXED:
            raise ProtocolError(
                ErrorCode.MALFORMED,
                f"{kind_name(header.kind)} has {bound} B, its header says {header.length}",
            )
        return header

    def _fit(self, length: int) -> None:
        if length <= len(self._body):
            del self._body[length:]
        else:
            self._grow(length)

    def _grow(self, length: int) -> None:
        self._body += _ZEROS[: length - len(self._body)]


def _length_bound(kind: int) -> int:
    return _KINDS[kind].max_length if kind in _KINDS else _UNKNOWN_KIND_BYTES


def kind_name(kind: int) -> str:
    """Returns the name of a kind, or "kind NUMBER" if it is unknown."""
    return _KINDS[kind].name if kind in _KINDS else f"kind {kind}"
