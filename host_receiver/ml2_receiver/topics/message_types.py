"""Classes of messages and services by the ROS names of their types."""

import importlib
from importlib.util import find_spec
from pathlib import Path
from typing import Any


def message_class(name: str) -> Any:
    """Returns the Python class of a type such as `sensor_msgs/msg/Image`.

    Raises:
        ImportError: its package is not installed, has no such type, or is no package of ROS
            messages and is therefore not imported.
    """
    return _made(name, "msg", "message")


def service_class(name: str) -> Any:
    """Returns the Python class of a type such as `std_srvs/srv/SetBool`.

    Raises:
        ImportError: as message_class().
    """
    return _made(name, "srv", "service")


def _made(name: str, folder: str, what: str) -> Any:
    package, _, type = name.partition(f"/{folder}/")
    if not _has_messages(package):
        raise ImportError(
            f"there is no package {package} of ROS messages here: install it, or source its "
            "workspace before the receiver starts"
        )
    found = getattr(importlib.import_module(f"{package}.{folder}"), type, None)
    if found is None:
        raise ImportError(f"package {package} has no {what} {type}")
    return found


def _has_messages(package: str) -> bool:
    """Returns True if rosidl made the package, without importing it."""
    spec = find_spec(package)
    folders = (spec and spec.submodule_search_locations) or ()
    made = f"{package}_s__rosidl_typesupport_c*.so"
    return any(next(Path(folder).glob(made), None) is not None for folder in folders)
