"""What the receiver publishes itself, as ROS messages."""

import json
from collections.abc import Iterable, Mapping

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import String

from ..diagnostics import Row
from ..sink import Applied


def applied_message(applied: Applied, prefix: str) -> String:
    """The JSON on `config`: per stream the result, its values, the reason and its topics."""
    streams = {
        id: {
            "result": answer.result,
            "values": answer.values,
            "reason": answer.reason,
            "topics": [
                {
                    "topic": topic.full_name(prefix),
                    "type": topic.type,
                    "qos": topic.qos,
                    "role": topic.role,
                }
                for topic in applied.topics
                if topic.stream == id
            ],
        }
        for id, answer in applied.streams.items()
    }
    content = {"headset": applied.headset, "session": applied.session, "streams": streams}
    return String(data=json.dumps(content))


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
