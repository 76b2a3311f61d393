"""/diagnostics without ROS: ROS reads what it would have written."""

import pytest

from ml2_receiver.topics.diagnostics import Level, Row
from ml2_receiver.topics.plain_messages import encode_statuses

pytest.importorskip("rclpy", reason="rclpy is not installed")

ROWS = [
    Row("session", Level.OK, "Brille ünit: connected", {"state": "connected", "k": ""}),
    Row("/magic_leap2/battery", Level.ERROR, "", {}),
    Row("clock", Level.WARN, "late", {"offset_ns": "-3"}),
]
MORE = {"/magic_leap2/battery": {"zenoh_published": "5"}}


@pytest.mark.parametrize("receiver", ["", "robot1"])
@pytest.mark.parametrize("rows", [ROWS, ROWS[:1], []])
def test_ros_reads_the_statuses(receiver: str, rows: list[Row]) -> None:
    from builtin_interfaces.msg import Time
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.serialization import deserialize_message, serialize_message

    from ml2_receiver.ros.status_array import status_array

    expected = status_array(receiver, rows, MORE, Time(sec=1700, nanosec=5))
    payload = encode_statuses(receiver, rows, MORE, 1_700_000_000_005)
    assert deserialize_message(payload, DiagnosticArray) == expected
    assert len(payload) == len(serialize_message(expected))  # whose padding is not defined
