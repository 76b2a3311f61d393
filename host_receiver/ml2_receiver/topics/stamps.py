"""Where the capture stamp stands in the raw bytes of a message."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable

_TIME = struct.Struct("<iI")
_LENGTH = struct.Struct("<I")
_NANOS_PER_SECOND = 1_000_000_000


def stamp_reader(message_type: str) -> Callable[[bytes], int]:
    """The function that reads the stamp of a message of this type, in nanoseconds, from its CDR."""
    if message_type == "std_msgs/msg/String":
        return _json_stamp
    if message_type == "tf2_msgs/msg/TFMessage":
        return _first_transform_stamp
    return _header_stamp


def _header_stamp(payload: bytes) -> int:
    sec, nanosec = _TIME.unpack_from(payload, 4)
    return int(sec) * _NANOS_PER_SECOND + int(nanosec)


def _first_transform_stamp(payload: bytes) -> int:
    sec, nanosec = _TIME.unpack_from(payload, 8)
    return int(sec) * _NANOS_PER_SECOND + int(nanosec)


def _json_stamp(payload: bytes) -> int:
    (size,) = _LENGTH.unpack_from(payload, 4)
    stamp = json.loads(payload[8 : 8 + size - 1])["stamp"]
    return int(stamp["sec"]) * _NANOS_PER_SECOND + int(stamp["nanosec"])
