"""diagnostic_msgs/DiagnosticArray as plain CDR, without ROS."""

import struct
from collections.abc import Iterable, Mapping

from ..wire.frame import CDR_ENCAPSULATION
from .diagnostics import Row
from .status_name import status_name

_UINT32, _TIME = struct.Struct("<I"), struct.Struct("<iI")
_HARDWARE = "magic_leap_2"


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
