"""The legal values of one key of the configuration, without regard to other keys."""

import math
import re
import sys

from ..wire.json_body import Scalar
from .stream_table import CAMERA_KEYS, Key

# Legal values of a key of type "link", as are numbers.
LINK_WORDS = ("auto", "fixed")

_SEGMENT = re.compile(r"\*\*?|[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_LONGEST_NAME = 255  # of a topic in DDS
_LONGEST_LINE = 63  # of the name of a map in OpenXR
_MOST_NAMES = 64
# https://design.ros2.org/articles/topic_and_service_names.html; the bound leaves room for the
# longest relative topic in the 247 bytes of RMW_TOPIC_MAX_NAME_LENGTH.
_TOPIC = re.compile(r"(?=.{1,200}$)(?!.*__)/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def accepts(value: object, key: Key) -> bool:
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
        case "file" | "line":
            return isinstance(value, str) and value.isprintable() and _is_short(value, key)
        case "names":
            return _are_rules(value.split() if isinstance(value, str) else value)
        case "topic":
            return isinstance(value, str) and _TOPIC.fullmatch(value) is not None
        case _:
            return isinstance(value, str) and value in key.allowed


def is_rule(text: object) -> bool:
    """Returns True for a resolved name of ROS, some of whose segments may be `*` or `**`."""
    if not isinstance(text, str) or len(text) > _LONGEST_NAME:
        return False
    first, *segments = text.split("/")
    return not first and bool(segments) and all(map(_SEGMENT.fullmatch, segments))


def _is_short(value: str, key: Key) -> bool:
    return key.type != "line" or len(value.encode()) <= _LONGEST_LINE


def _are_rules(value: object) -> bool:
    return isinstance(value, list) and len(value) <= _MOST_NAMES and all(map(is_rule, value))


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
        case "line":
            return f"a text of at most {_LONGEST_LINE} bytes in one line, or nothing"
        case "names":
            return (
                f"a list of at most {_MOST_NAMES} absolute names such as /robot/scan, whose"
                " segments may be * or **"
            )
        case "topic":
            return f"a topic name such as {key.default}"
        case _:
            return f"one of {', '.join(map(str, key.allowed))}"


def scalar(value: object, key: Key) -> Scalar:
    """Returns a value that the key accepts as Config.values has it."""
    if isinstance(value, list):
        return " ".join(value)
    assert isinstance(value, bool | int | float | str)
    return mbit_per_s(value) if key.type == "link" else value


def mbit_per_s(value: Scalar) -> Scalar:
    """Returns the number in a text, which a ROS parameter is; everything else as it is."""
    try:
        number = float(value) if isinstance(value, str) else value
    except ValueError:
        return value
    is_whole = isinstance(number, float) and number.is_integer()
    return int(number) if is_whole else number
