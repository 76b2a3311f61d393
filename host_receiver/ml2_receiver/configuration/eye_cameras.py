"""Which eye cameras may be switched on while the receiver runs, since their images are biometric.

Anybody in the ROS domain can set parameters. The file and the ROS arguments of the start are the
operator's own.
"""

from collections.abc import Iterator

from ..errors import Problem
from ..table.reader import load_table
from .config_rules import Values

_KEY = "general.eye_cameras"
_ALLOWED = "allowed"


def eye_camera_problems(operators: Values, values: Values) -> Iterator[Problem]:
    """Yields what the operator has to write before others may set `values`.

    Args:
        operators: the values that are the operator's own.
    """
    if values[_KEY] != operators[_KEY]:
        message = (
            f"expected {operators[_KEY]}, found {values[_KEY]}: ROS parameters cannot change it;"
            " write it in the configuration file, then call ~/reload"
        )
        yield Problem(0, _KEY, str(values[_KEY]), message)
    for section in sorted(_eye_cameras_on(values) - _allowed(operators)):
        message = (
            f"images of eyes are biometric, and ROS parameters do not switch them on: write {_KEY}:"
            f" {_ALLOWED}, or {section}.enabled: true, in the configuration file, then call"
            " ~/reload"
        )
        yield Problem(0, f"{section}.enabled", "true", message)


def _allowed(operators: Values) -> set[str]:
    return _eye_cameras() if operators[_KEY] == _ALLOWED else _eye_cameras_on(operators)


def _eye_cameras_on(values: Values) -> set[str]:
    return {id for id in _eye_cameras() if values[f"{id}.enabled"]}


def _eye_cameras() -> set[str]:
    return {it.id for it in load_table().sections.values() if it.shows_eyes}
