"""std_msgs/String to and from plain CDR, without ROS."""

import struct

from ..wire.frame import CDR_ENCAPSULATION

_LENGTH = struct.Struct("<I")
_TEXT = len(CDR_ENCAPSULATION) + _LENGTH.size


def encode_string(text: str) -> bytes:
    """Returns the payload of a String."""
    data = text.encode() + b"\0"
    return CDR_ENCAPSULATION + _LENGTH.pack(len(data)) + data


def decode_string(payload: bytes) -> bytes:
    """Returns the text in the payload of a String.

    Raises:
        ValueError: the payload is not that of a String.
    """
    if len(payload) >= _TEXT and payload.startswith(CDR_ENCAPSULATION):
        (length,) = _LENGTH.unpack_from(payload, len(CDR_ENCAPSULATION))
        if 1 <= length <= len(payload) - _TEXT:
            return payload[_TEXT : _TEXT + length - 1]
    raise ValueError("not a std_msgs/String")
