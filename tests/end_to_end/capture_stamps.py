"""Reads the stamps of decoded ROS messages."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any


def nanos(time: Any) -> int:
    """Returns a builtin_interfaces/Time in ns."""
    return int(time.sec) * 1_000_000_000 + int(time.nanosec)


def stamp_ns(message: Any) -> int:
    """Returns the stamp of a message with a header, or of a metadata message."""
    if hasattr(message, "header"):
        return nanos(message.header.stamp)
    return nanos(SimpleNamespace(**json.loads(message.data)["stamp"]))
