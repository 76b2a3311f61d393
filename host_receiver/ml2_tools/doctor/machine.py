"""Reads the state of this machine for `ml2-receiver doctor`; `findings` judges it."""

import ctypes
import importlib.util
import os
from pathlib import Path

_KERNEL = Path("/proc/sys")
_UFW = Path("/etc/ufw/ufw.conf")
_FIREWALLD = Path("/run/firewalld")

# struct timex of adjtimex(2) on 64-bit Linux.
_TIMEX_BYTES = 208
_TIME_ERROR = 5

ROS_MODULES = ("rclpy", "std_msgs", "sensor_msgs", "geometry_msgs", "diagnostic_msgs", "tf2_msgs")


def missing_modules() -> list[str]:
    """Returns the modules of ROS 2 that the receiver needs and Python does not find."""
    return [name for name in ROS_MODULES if importlib.util.find_spec(name) is None]


def kernel_number(name: str) -> int | None:
    """A sysctl such as net.core.rmem_max; None where the kernel has none."""
    try:
        return int((_KERNEL / name.replace(".", "/")).read_text())
    except (OSError, ValueError):
        return None


def firewall() -> str | None:
    """The firewall that is switched on, "ufw" or "firewalld"; nftables alone tell root only."""
    try:
        if "ENABLED=yes" in _UFW.read_text():
            return "ufw"
    except OSError:
        pass
    return "firewalld" if _FIREWALLD.exists() else None


def is_clock_synchronised() -> bool:
    """Returns True if a program such as chrony, ntpd or timesyncd synchronises the clock."""
    timex = ctypes.create_string_buffer(_TIMEX_BYTES)  # modes = 0 only reads
    state: int = ctypes.CDLL(None, use_errno=True).adjtimex(timex)
    if state < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return state != _TIME_ERROR
