"""Refuses changes that only the operator may make at runtime: eye cameras, rules for apps.

Anybody in the ROS domain can set parameters. The file and the ROS arguments of the start are the
operator's own.
"""

from collections.abc import Iterator

from ..errors import Problem
from ..table.reader import load_table
from .app_rules import USES
from .config_rules import Values

_EYE_CAMERAS = "general.eye_cameras"
_ALLOWED = "allowed"
_KEYS = (_EYE_CAMERAS, *(f"app.{use}" for use in USES))


def operators_problems(operators: Values, values: Values) -> Iterator[Problem]:
    """Yields what the operator has to write before others may set `values`.

    Args:
        operators: the values that are the operator's own.
    """
    for key in _KEYS:
        if values[key] != operators[key]:
            expected, found = operators[key] or "nothing", values[key] or "nothing"
            message = (
                f"expected {expected}, found {found}: ROS parameters cannot change it; write it in"
                " the configuration file, then call ~/reload"
            )
            yield Problem(0, key, str(values[key]), message)
    for section in sorted(_eye_cameras_on(values) - _allowed(operators)):
        message = (
            f"images of eyes are biometric, and ROS parameters do not switch them on: write"
            f" {_EYE_CAMERAS}: {_ALLOWED}, or {section}.enabled: true, in the configuration file,"
            " then call ~/reload"
        )
        yield Problem(0, f"{section}.enabled", "true", message)


def _allowed(operators: Values) -> set[str]:
    return _eye_cameras() if operators[_EYE_CAMERAS] == _ALLOWED else _eye_cameras_on(operators)


def _eye_cameras_on(values: Values) -> set[str]:
    return {id for id in _eye_cameras() if values[f"{id}.enabled"]}


def _eye_cameras() -> set[str]:
    return {it.id for it in load_table().sections.values() if it.shows_eyes}
