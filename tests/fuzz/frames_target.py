"""Frames: what is read does not depend on how the bytes are cut up, and needs no more memory."""

from collections.abc import Iterator
from typing import Any

from ml2_receiver.errors import ProtocolError
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.frame import HEADER_BYTES, FrameParser, Header
from ml2_receiver.wire.kinds import OPENING, ROS_LANES, Side
from vectors import vectors

_TABLE = load_table()
_NAMES = ("control", "time", "link_test", "pairing", *_TABLE.lanes)
_LANES = (OPENING, *map(_TABLE.lane, _NAMES), *ROS_LANES)
# Added to the lane of a session that knows the kinds of openings.
_HAS_OPENINGS = 128
_SIDES = list(Side)
_GROWTH_BYTES = 1 << 20

type Found = list[tuple[Header, bytes] | str]


def seeds() -> Iterator[bytes]:
    """Side, lane, and the bytes of one connection."""
    for case, data in (*vectors("wire"), *vectors("malformed")):
        lane = _TABLE.lane(case["lane"])
        side = Side.DEVICE if case.get("side", "receiver") != "device" else Side.RECEIVER
        openings = _HAS_OPENINGS if _has_openings(case) else 0
        for it in (lane, OPENING):
            yield bytes([_SIDES.index(side), _LANES.index(it) + openings]) + data


def _has_openings(case: dict[str, Any]) -> bool:
    return "ros" in case or case.get("given") in ("opening", "opened")


def read(data: bytes) -> None:
    side, lane = (_SIDES[data[0] % len(_SIDES)], _LANES[data[1] % _HAS_OPENINGS % len(_LANES)])
    has_openings = data[1] >= _HAS_OPENINGS
    stream = data[2:]
    whole = parsed(FrameParser(side, lane, has_openings=has_openings), stream, len(stream))
    for piece in (1, 7):
        parser = FrameParser(side, lane, has_openings=has_openings)
        assert parsed(parser, stream, piece) == whole


def parsed(parser: FrameParser, stream: bytes, piece: int) -> Found:
    """The frames, and the code of the error that ends them."""
    found: Found = []
    at = most = 0
    while at < len(stream):
        into = parser.get_buffer()
        assert 0 < len(into) <= max(HEADER_BYTES, _GROWTH_BYTES, most)
        count = min(len(into), piece, len(stream) - at)
        into[:count] = stream[at : at + count]
        at += count
        try:
            frame = parser.buffer_updated(count)
        except ProtocolError as error:
            return [*found, error.code]
        if frame is not None:
            assert len(frame.body) == frame.header.length
            most = max(most, len(frame.body))
            found.append((frame.header, bytes(frame.body)))
    return found
