"""The capture stamps of messages, raw or decoded."""

import json
import struct
from collections.abc import Callable
from typing import Any

from .plain_messages import decode_string

_TIME = struct.Struct("<iI")
_NANOS_PER_SECOND = 1_000_000_000


def stamp_reader(message_type: str) -> Callable[[bytes], int]:
    """Returns a function that reads the stamp of a message of this type from its CDR, in ns.

    The function raises ValueError for a payload without a stamp.
    """
    read = _READERS.get(message_type, _header_stamp)

    def stamp_ns(payload: bytes) -> int:
        try:
            return read(payload)
        except (struct.error, KeyError, TypeError, OverflowError, RecursionError) as error:
            raise ValueError(f"{message_type} without a stamp: {error}") from error

    return stamp_ns


def header_stamp_ns(header: Any) -> int:
    """Returns the stamp of a decoded std_msgs/Header, in ns."""
    return int(header.stamp.sec) * _NANOS_PER_SECOND + int(header.stamp.nanosec)


def _header_stamp(payload: bytes) -> int:
    sec, nanosec = _TIME.unpack_from(payload, 4)
    return int(sec) * _NANOS_PER_SECOND + int(nanosec)


def _first_transform_stamp(payload: bytes) -> int:
    sec, nanosec = _TIME.unpack_from(payload, 8)
    return int(sec) * _NANOS_PER_SECOND + int(nanosec)


def _json_stamp(payload: bytes) -> int:
    stamp = json.loads(decode_string(payload))["stamp"]
    # Text can have numbers that no time of ROS has.
    return _header_stamp(bytes(4) + _TIME.pack(int(stamp["sec"]), int(stamp["nanosec"])))


_READERS: dict[str, Callable[[bytes], int]] = {
    "std_msgs/msg/String": _json_stamp,
    "tf2_msgs/msg/TFMessage": _first_transform_stamp,
}
