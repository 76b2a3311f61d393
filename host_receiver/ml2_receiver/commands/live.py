"""What commands that watch a running receiver share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..errors import RosError

if TYPE_CHECKING:
    from ..watch.diagnostics_node import DiagnosticsNode

PATIENCE_S = 10.0


@contextmanager
def diagnostics_node() -> Iterator[DiagnosticsNode]:
    """A node that hears receivers.

    Raises:
        RosError: ROS is missing or does not start.
    """
    try:
        from ..watch.diagnostics_node import DiagnosticsNode
    except ModuleNotFoundError as error:
        raise RosError(f"{error.name} is missing: source ROS 2 Jazzy") from error
    node = DiagnosticsNode()
    try:
        yield node
    finally:
        node.close()
