"""Has a running receiver try the link to its headset, as any ROS node could."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING

from ml2_receiver.errors import RosError

from ..live.receiver_client import ReceiverClient

if TYPE_CHECKING:
    from ..live.diagnostics import Values
    from ..live.diagnostics_node import DiagnosticsNode

_SERVICE = "test_link"
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
    name = node.node_name(receiver, _ANSWER_S)
    with closing(ReceiverClient(node.context, name, _ANSWER_S, [_SERVICE])) as client:
        is_done, reason = client.call(_SERVICE)
    if not is_done:
        raise RosError(reason)

    def is_over(row: Values) -> bool:
        return row.get("tests") != before and row.get("state") != "running"

    return node.rows(receiver, _TEST_S, lambda rows: is_over(rows.get("link", {})))["link"]
