"""/diagnostics as a ROS message."""

from collections.abc import Iterable, Mapping

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from ..diagnostics import Row


def status_array(
    rows: Iterable[Row], more: Mapping[str, Mapping[str, str]], stamp: Time
) -> DiagnosticArray:
    """/diagnostics; `more` has further values by the row's name."""
    array = DiagnosticArray(status=[_status(row, more.get(row.name, {})) for row in rows])
    array.header.stamp = stamp
    return array


def _status(row: Row, more: Mapping[str, str]) -> DiagnosticStatus:
    values = {**row.values, **more}
    return DiagnosticStatus(
        level=bytes([row.level]),
        name=f"ml2_receiver: {row.name}",
        message=row.message,
        hardware_id="magic_leap_2",
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
