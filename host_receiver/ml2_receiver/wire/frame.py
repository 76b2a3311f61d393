"""Frames: the 32-byte header, and a parser without I/O."""

import struct
from collections.abc import Iterator
from typing import NamedTuple

from ..errors import ErrorCode, ProtocolError
from .kinds import KIND_BY_NUMBER, OPENING, Body, Kind, Lane, Side, kind_name, max_bytes

MAGIC = 0x324D
VERSION = 1
CDR_ENCAPSULATION = b"\x00\x01\x00\x00"

# The first two bytes of a TLS connection: a handshake record, major version 3.
_TLS_MAGIC = 0x0316
_LAYOUT = struct.Struct("<HBBHHIIqq")
HEADER_BYTES = _LAYOUT.size
# The body buffer grows at most this far ahead of the bytes that have arrived.
_GROWTH_BYTES = 1 << 20
_ZEROS = memoryview(bytes(_GROWTH_BYTES))
_FIXED = {kind for kind in Kind if kind.body in (Body.TIMES, Body.POSE)}


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
    """A complete frame. `body` is the parser's own buffer, see FrameParser."""

    header: Header
    body: bytearray


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
    fields = {"channel": channel, "sequence": sequence, "capture_ns": capture_ns}
    return encode_header(kind, len(body), **fields, send_ns=send_ns) + body


def encode_header(
    kind: Kind, length: int, *, channel: int, sequence: int, capture_ns: int, send_ns: int
) -> bytes:
    """Returns the header of a frame whose body has this length.

    Raises:
        ValueError: the kind does not allow it.
    """
    if length > kind.max_length:
        raise ValueError(f"{kind.name} takes {kind.max_length} B, got {length}")
    fields = (MAGIC, VERSION, kind, 0, channel, sequence, length, capture_ns, send_ns)
    return _LAYOUT.pack(*fields)


class FrameParser:
    """A parser that turns the bytes of one connection into frames.

    It is used like asyncio.BufferedProtocol: receive into get_buffer(), then pass the number of
    received bytes to buffer_updated(), which returns a completed frame or None. Where frames are
    small, receive many at once and pass the bytes to feed() instead. A frame's body
    is one bytearray that is reused: it has exactly the body's length and is valid until the next
    get_buffer(). Its memory grows with the bytes that arrived, not to the length in the header, and
    is kept for the next frame.

    Not thread-safe. The parser cannot be used after a ProtocolError.

    Args:
        sender: the side that sends these bytes.
        lane: what the connection is; call enter() when HELLO or JOIN names the lane.
        has_openings: True if the session knows the kinds of openings.
    """

    def __init__(self, sender: Side, lane: Lane = OPENING, *, has_openings: bool = False) -> None:
        self._sender = sender
        self.enter(lane, has_openings=has_openings)
        self._head = bytearray(HEADER_BYTES)
        self._body = bytearray()
        self._header: Header | None = None
        self._view = memoryview(b"")
        self._filled = 0

    @property
    def lane(self) -> Lane:
        return self._lane

    def enter(self, lane: Lane, *, has_openings: bool = False) -> None:
        """Takes the lane that the connection has become."""
        self._lane = lane
        self._known = {
            number: kind
            for number, kind in KIND_BY_NUMBER.items()
            if has_openings or not kind.is_of_openings
        }
        self._limits = {
            number: min(kind.max_length, lane.max_payload_bytes)
            if kind.body is Body.PAYLOAD
            else kind.max_length
            for number, kind in self._known.items()
            if kind.sender & self._sender and kind.lanes & lane.kind
        }

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
        kind = self._known.get(header.kind)
        bound = max_bytes(kind) if limit is None else limit
        if header.length > bound:
            raise ProtocolError(
                ErrorCode.TOO_LARGE,
                f"{kind_name(header.kind)} takes {bound} B, its header says {header.length}",
            )
        if limit is None and (kind is not None or self._lane is OPENING):
            lane = "a new connection" if self._lane is OPENING else f"lane {self._lane.name}"
            raise ProtocolError(ErrorCode.UNEXPECTED, f"{kind_name(header.kind)} on {lane}")
        if header.length < bound and kind in _FIXED:
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
        ahead = min(length, self._filled + _GROWTH_BYTES)
        self._body += _ZEROS[: max(0, ahead - len(self._body))]
