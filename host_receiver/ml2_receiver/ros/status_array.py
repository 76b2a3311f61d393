"""/diagnostics as a ROS message."""

from collections.abc import Iterable, Mapping

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from ..topics.diagnostics import Row
from ..topics.plain_messages import status_name

DIAGNOSTICS = "/diagnostics"


def status_array(
    receiver: str, rows: Iterable[Row], more: Mapping[str, Mapping[str, str]], stamp: Time
) -> DiagnosticArray:
    """/diagnostics; `more` has further values by the row's name."""
    array = DiagnosticArray(status=[_status(receiver, it, more.get(it.name, {})) for it in rows])
    array.header.stamp = stamp
    return array


def _status(receiver: str, row: Row, more: Mapping[str, str]) -> DiagnosticStatus:
    values = {**row.values, **more}
    return DiagnosticStatus(
        level=bytes([row.level]),
        name=status_name(receiver, row.name),
        message=row.message,
        hardware_id="magic_leap_2",
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
