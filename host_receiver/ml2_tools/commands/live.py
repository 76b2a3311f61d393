"""Common parts of the commands that watch a running receiver."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING

from ml2_receiver.commands.ros_start import ros_needed

if TYPE_CHECKING:
    from ..live.diagnostics_node import DiagnosticsNode
    from ..live.receiver_client import ReceiverClient

PATIENCE_S = 10.0


@contextmanager
def diagnostics_node() -> Iterator[DiagnosticsNode]:
    """A node that hears receivers.

    Raises:
        RosError: ROS is missing or does not start.
    """
    with ros_needed():
        from ..live.diagnostics_node import DiagnosticsNode
    node = DiagnosticsNode()
    try:
        yield node
    finally:
        node.close()


@contextmanager
def receiver_client(
    receiver: str, timeout_s: float, services: Iterable[str] = ()
) -> Iterator[ReceiverClient]:
    """A client of one running receiver, which will call these services.

    Raises:
        RosError: ROS is missing or does not start, or there is no such receiver.
    """
    with diagnostics_node() as node:
        from ..live.receiver_client import ReceiverClient

        name = node.node_name(receiver, timeout_s)
        with closing(ReceiverClient(node.context, name, timeout_s, services)) as client:
            yield client
