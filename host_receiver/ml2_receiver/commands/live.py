"""What commands that watch a running receiver share."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..errors import RosError

if TYPE_CHECKING:
    from ..diagnostics_node import DiagnosticsNode

PATIENCE_S = 10.0


def stopped_by_signals() -> threading.Event:
    """Set by SIGINT and SIGTERM, which then end nothing by themselves."""
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    return stopping


@contextmanager
def diagnostics_node() -> Iterator[DiagnosticsNode]:
    """A node that hears receivers.

    Raises:
        RosError: ROS is missing or does not start.
    """
    try:
        from ..diagnostics_node import DiagnosticsNode
    except ModuleNotFoundError as error:
        raise RosError(f"{error.name} is missing: source ROS 2 Jazzy") from error
    node = DiagnosticsNode()
    try:
        yield node
    finally:
        node.close()
