"""The legal values of one key of the configuration, without regard to other keys."""

import math
import re
import sys
from typing import TypeGuard

from ..wire.json_body import Scalar
from .stream_table import CAMERA_KEYS, Key

# Legal values of a key of type "link", as are numbers.
LINK_WORDS = ("auto", "fixed")

# https://design.ros2.org/articles/topic_and_service_names.html; the bound leaves room for the
# longest relative topic in the 247 bytes of RMW_TOPIC_MAX_NAME_LENGTH.
_TOPIC = re.compile(r"(?=.{1,200}$)(?!.*__)/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def accepts(value: object, key: Key) -> TypeGuard[Scalar]:
    """Returns True if the value is legal for some values of the other keys."""
    match key.type:
        case "bool":
            return isinstance(value, bool)
        case "integer":
            if key.name in CAMERA_KEYS:  # whether a mode has the value depends on the others
                return type(value) is int
            return type(value) is int and (
                value in key.allowed if key.allowed else _is_within(value, key)
            )
        case "number":
            if isinstance(value, bool) or not isinstance(value, int | float):
                return False
            return _is_within(value, key)
        case "link":
            return _is_link(value)
        case "file":
            return isinstance(value, str) and value.isprintable()
        case "topic":
            return isinstance(value, str) and _TOPIC.fullmatch(value) is not None
        case _:
            return isinstance(value, str) and value in key.allowed


def _is_link(value: object) -> bool:
    if not isinstance(value, int | float | str) or isinstance(value, bool):
        return False
    number = mbit_per_s(value)
    if isinstance(number, str):
        return number in LINK_WORDS
    return 0 < number <= sys.float_info.max


def _is_within(value: float, key: Key) -> bool:
    least = -math.inf if key.minimum is None else key.minimum
    return least <= value <= (sys.float_info.max if key.maximum is None else key.maximum)


def expected(key: Key) -> str:
    """Returns the legal values of a key in words."""
    match key.type:
        case "bool":
            return "true or false"
        case "integer" if not key.allowed:
            return f"a whole number from {key.minimum:g} to {key.maximum:g}"
        case "number":
            return "a number" if key.minimum is None else f"a number of at least {key.minimum}"
        case "link":
            return f"{', '.join(LINK_WORDS)}, or a number of Mbit/s above 0"
        case "file":
            return "the name of a file, or nothing"
        case "topic":
            return f"a topic name such as {key.default}"
        case _:
            return f"one of {', '.join(map(str, key.allowed))}"


def mbit_per_s(value: Scalar) -> Scalar:
    """Returns the number in a text, which a ROS parameter is; everything else as it is."""
    try:
        number = float(value) if isinstance(value, str) else value
    except ValueError:
        return value
    is_whole = isinstance(number, float) and number.is_integer()
    return int(number) if is_whole else number
