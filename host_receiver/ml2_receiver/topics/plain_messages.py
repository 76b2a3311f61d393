"""String, DiagnosticArray and TFMessage of ROS as plain CDR, without ROS.

Names of rows in /diagnostics are "ml2_receiver: session", or "robot1/ml2_receiver: session".
"""

import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ..wire.frame import CDR_ENCAPSULATION
from .diagnostics import Row

_NODE = "ml2_receiver"
_LENGTH = struct.Struct("<I")
_TEXT = len(CDR_ENCAPSULATION) + _LENGTH.size
_UINT32, _TIME = struct.Struct("<I"), struct.Struct("<iI")
_POSE, _DOUBLE_BYTES = struct.Struct("<7d"), 8
_HARDWARE = "magic_leap_2"


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


@dataclass(frozen=True)
class StaticTransform:
    """A pose of `child` in `parent`, both frame ids.

    Attributes:
        translation_m: x, y, z.
        rotation: the unit quaternion x, y, z, w.
    """

    parent: str
    child: str
    translation_m: tuple[float, float, float]
    rotation: tuple[float, float, float, float]


def append_transforms(
    payload: bytes | bytearray, transforms: Sequence[StaticTransform]
) -> bytearray:
    """Returns the payload of a TFMessage with more transforms, whose stamps are 0.

    Args:
        payload: of a TFMessage; an empty one stands for one without transforms.
    """
    body = bytearray(payload[len(CDR_ENCAPSULATION) :] or _UINT32.pack(0))
    (count,) = _UINT32.unpack_from(body)
    _UINT32.pack_into(body, 0, count + len(transforms))
    for it in transforms:
        body += bytes(-len(body) % _UINT32.size) + bytes(_TIME.size)
        _add_string(body, it.parent)
        _add_string(body, it.child)
        body += bytes(-len(body) % _DOUBLE_BYTES) + _POSE.pack(*it.translation_m, *it.rotation)
    return bytearray(CDR_ENCAPSULATION) + body


def status_name(receiver: str, row: str) -> str:
    """Returns the name of a row; `receiver` is as in --name, or empty."""
    return f"{receiver}/{_NODE}: {row}" if receiver else f"{_NODE}: {row}"


def split_status_name(name: str) -> tuple[str, str] | None:
    """Returns receiver and row; None for a row of another node."""
    node, colon, row = name.partition(": ")
    receiver, slash, last = node.rpartition("/")
    return (receiver, row) if colon and last == _NODE and bool(receiver) == bool(slash) else None


def encode_statuses(
    receiver: str, rows: Iterable[Row], more: Mapping[str, Mapping[str, str]], stamp_ns: int
) -> bytes:
    """Returns the payload of /diagnostics.

    Args:
        receiver: as in --name, may be empty.
        more: further values by the name of their row.
        stamp_ns: UTC.
    """
    body = bytearray(_TIME.pack(*divmod(stamp_ns, 1_000_000_000)))
    _add_string(body, "")  # frame_id
    rows = list(rows)
    _add_count(body, len(rows))
    for row in rows:
        body.append(row.level)
        for text in (status_name(receiver, row.name), row.message, _HARDWARE):
            _add_string(body, text)
        values = {**row.values, **more.get(row.name, {})}
        _add_count(body, len(values))
        for key, value in values.items():
            _add_string(body, key)
            _add_string(body, value)
    return CDR_ENCAPSULATION + bytes(body)


def _add_string(body: bytearray, text: str) -> None:
    data = text.encode() + b"\0"
    _add_count(body, len(data))
    body += data


def _add_count(body: bytearray, count: int) -> None:
    body += bytes(-len(body) % _UINT32.size) + _UINT32.pack(count)
