"""Has a running receiver try the link to its headset, as any ROS node could."""

from __future__ import annotations

from typing import TYPE_CHECKING

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger

from ml2_receiver.errors import RosError
from ml2_receiver.ros.spinning import spin_until

if TYPE_CHECKING:
    from ..live.diagnostics_node import DiagnosticsNode, Values

_SERVICE = "ml2_receiver/test_link"
_ANSWER_S = 10.0
_TEST_S = 12.0  # 8 s until it counts as unanswered, PROTOCOL.md, and what /diagnostics take


def try_link(node: DiagnosticsNode, receiver: str) -> Values:
    """The row "link" of /diagnostics once a new test is over, as a rule after 2 s or 3.

    Args:
        receiver: as in its --name, or empty.

    Raises:
        RosError: there is no test.
    """
    before = node.rows(receiver, _ANSWER_S).get("link", {}).get("tests")
    _trigger(node.context, "/".join(filter(None, ("", receiver, _SERVICE))))

    def is_over(row: Values) -> bool:
        return row.get("tests") != before and row.get("state") != "running"

    return node.rows(receiver, _TEST_S, lambda rows: is_over(rows.get("link", {})))["link"]


def _trigger(context: Context, service: str) -> None:
    node = rclpy.create_node("ml2_tools_call", context=context)
    try:
        client = node.create_client(Trigger, service)
        if not client.wait_for_service(_ANSWER_S):
            raise RosError(f"the receiver has no service {service}")
        answer = client.call_async(Trigger.Request())
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        spin_until(executor, answer.done, _ANSWER_S)
        executor.shutdown()
    finally:
        node.destroy_node()
    if not answer.done():
        raise RosError(f"{service} does not answer")
    if not answer.result().success:
        raise RosError(answer.result().message)
