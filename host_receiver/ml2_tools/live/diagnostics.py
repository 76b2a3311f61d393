"""Reads /diagnostics, on which every node of the ROS domain may publish."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message

from ml2_receiver.printable import printable
from ml2_receiver.topics.plain_messages import split_status_name

type Values = Mapping[str, str]
type Rows = Mapping[str, Values]

TYPE = "diagnostic_msgs/msg/DiagnosticArray"
# A value may be JSON of all streams.
_LONGEST = 64 * 1024


@dataclass(frozen=True)
class Diagnosed:
    """The rows of one receiver.

    Attributes:
        rows: the values by row ("session", "clock", and the topics), and the row's own words as
            "message". All text is printable.
        levels: the level of each row.
    """

    rows: dict[str, Values] = field(default_factory=dict)
    levels: dict[str, int] = field(default_factory=dict)


def read_diagnostics(payload: bytes) -> dict[str, Diagnosed]:
    """Reads the CDR of a message; returns the rows of each receiver by its name, or empty."""
    found: dict[str, Diagnosed] = {}
    for status in deserialize_message(payload, DiagnosticArray).status:
        if (name := split_status_name(status.name)) is not None:
            receiver, row = map(printable, name)
            values = {printable(it.key): printable(it.value, _LONGEST) for it in status.values}
            diagnosed = found.setdefault(receiver, Diagnosed())
            diagnosed.rows[row] = values | {"message": printable(status.message)}
            diagnosed.levels[row] = status.level[0]
    return found
