"""Message classes by the names ROS gives their types."""

from __future__ import annotations

import importlib
from typing import Any


def message_class(name: str) -> Any:
    """The Python class of a type such as `sensor_msgs/msg/Image`.

    Raises:
        ImportError: its package is not installed.
    """
    package, _, message = name.partition("/msg/")
    return getattr(importlib.import_module(f"{package}.msg"), message)
