"""Common parts of the commands that watch a running receiver."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager
from typing import TYPE_CHECKING

from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.printable import markup, printable

if TYPE_CHECKING:
    from ..live.diagnostics_node import DiagnosticsNode
    from ..live.receiver_client import ReceiverClient

PATIENCE_S = 10.0
_REPORT_S = 1.5  # a receiver reports once a second


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
def found_receiver(receiver: str, timeout_s: float) -> Iterator[DiagnosticsNode]:
    """A node that has heard of a receiver. Until it has, a terminal shows that it looks for it.

    Raises:
        RosError: ROS is missing or does not start, or there is no such receiver.
    """
    with ExitStack() as stack:
        with looking(named(receiver), f"for up to {timeout_s:g} s"):  # ROS takes a second to start
            node = stack.enter_context(diagnostics_node())
            node.rows(receiver, timeout_s)
        yield node


def named(receiver: str) -> str:
    return f"the receiver {receiver}" if receiver else "a receiver"


def looking(what: str, how_long: str) -> AbstractContextManager[object]:
    """Says what a command looks for, and for how long, until left; not without a terminal."""
    from rich.console import Console  # not needed by --help

    domain = os.environ.get("ROS_DOMAIN_ID", "0")
    words = f"looking for {what} in ROS domain {domain}, {how_long}"
    return Console(stderr=True).status(markup(words))


@contextmanager
def receiver_client(
    receiver: str, timeout_s: float, services: Iterable[str] = ()
) -> Iterator[tuple[DiagnosticsNode, ReceiverClient]]:
    """A client of one running receiver, which will call these services, and what hears receivers.

    Raises:
        RosError: ROS is missing or does not start, or there is no such receiver.
    """
    with found_receiver(receiver, timeout_s) as node:
        from ..live.receiver_client import ReceiverClient

        name = node.node_name(receiver, timeout_s)
        with closing(ReceiverClient(node.context, name, timeout_s, services)) as client:
            yield node, client


def whom(node: DiagnosticsNode, client: ReceiverClient, receiver: str) -> str:
    """Returns the receiver that later requests will reach, and ": "; empty if there is only one.

    Warns on standard error if several receivers have that name, for all get them. Is called before
    a request: a receiver that ROS finds after it may not get it.

    Args:
        receiver: as in its --name, or empty.
    """
    receivers = client.receivers()
    count = receivers.get(client.name, 1)
    if count > 1:
        heard = ", ".join(node.processes(receiver, count, _REPORT_S))
        found = f" on {heard}" if heard else ""
        print(
            f"WARNING: {count} receivers have the name {printable(client.name)}, and each gets"
            f" this{found}. Start each with a --name of its own.",
            file=sys.stderr,
        )
        return f"{client.name}{found}: "
    return f"{client.name}: " if len(receivers) > 1 else ""
