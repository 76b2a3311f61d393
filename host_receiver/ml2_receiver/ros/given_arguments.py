"""The arguments after --ros-args of a command; they hold for its whole process, as in ROS."""

from collections.abc import Sequence

_given: list[str] = []


def give(arguments: Sequence[str]) -> None:
    """Replaces the arguments of all contexts that are made later without their own."""
    _given[:] = arguments


def given() -> list[str]:
    """Returns the arguments, such as `["--ros-args", ...]`; empty for none."""
    return list(_given)
