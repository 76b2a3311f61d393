"""A topic of a recording, and its quality of service as rosbag2 writes it."""

from dataclasses import dataclass
from typing import Any

from ..table.stream_table import Qos

_INFINITE = {"sec": 9223372036, "nsec": 854775807}  # RMW_DURATION_INFINITE of rmw/time.h


@dataclass(frozen=True)
class BagTopic:
    """A topic; `name` is absolute, `type` such as "sensor_msgs/msg/Image"."""

    name: str
    type: str
    qos: Qos

    def offered_qos_profiles(self) -> list[dict[str, Any]]:
        """Returns the publisher's QoS as metadata of version 9 has it: RELIABLE, KEEP_LAST."""
        return [
            {
                "history": "keep_last",
                "depth": self.qos.depth,
                "reliability": "reliable",
                "durability": self.qos.durability,
                "deadline": _INFINITE,
                "lifespan": _INFINITE,
                "liveliness": "automatic",
                "liveliness_lease_duration": _INFINITE,
                "avoid_ros_namespace_conventions": False,
            }
        ]
