"""What follows --ros-args of a command; for its whole process, as ROS's own programs have it."""

from collections.abc import Sequence

_given: list[str] = []


def give(arguments: Sequence[str]) -> None:
    """Replaces the arguments of all contexts that are made later without their own."""
    _given[:] = arguments


def given() -> list[str]:
    """Returns the arguments, such as `["--ros-args", ...]`; empty for none."""
    return list(_given)
