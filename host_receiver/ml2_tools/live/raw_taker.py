"""The driver's RawTaker, for tools: what cannot be taken is a fault."""

from rclpy.node import Node

from ml2_receiver.ros.raw_taker import RawSubscription
from ml2_receiver.ros.raw_taker import RawTaker as DriversRawTaker

from .faults import Faults

__all__ = ["RawSubscription", "RawTaker"]


class RawTaker(DriversRawTaker):
    """Counts, and says once, what cannot be subscribed to or taken."""

    def __init__(
        self,
        node: Node,
        subscriptions: list[RawSubscription],
        pause_s: float = 0,
        faults: Faults | None = None,
    ) -> None:
        super().__init__(node, list(subscriptions), (faults or Faults()).add, pause_s)
