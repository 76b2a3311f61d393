"""The service that keeps values in the configuration file: those alone that are asked for by name.

Anybody in the ROS domain can set parameters, and what is in the file also holds for the next start.
"""

from dataclasses import replace
from difflib import get_close_matches

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from ..configuration.config_file import ConfigFile
from ..configuration.config_rules import MODE_KEYS, Values
from ..configuration.operators import operators_problems
from ..configuration.parameter_file import MAX_SHOWN
from ..configuration.settings import cameras, mode_name
from ..errors import ConfigError, Problem
from .outcome import Outcome, trigger
from .parameters import ParameterNode

SAVED_KEYS = "save.keys"
_DESCRIPTION = (
    "Keys that the next ~/save_config writes to the configuration file, with spaces between; empty"
    " afterwards."
)
_MAX_LISTED = 10


def add_save_service(node: ParameterNode, file: ConfigFile) -> None:
    """Adds ~/save_config and its parameter `save.keys`."""
    node.declare_parameter(SAVED_KEYS, "", ParameterDescriptor(description=_DESCRIPTION))

    def save() -> Outcome:
        asked_for = node.get_parameter(SAVED_KEYS).value.split()
        node.set_parameters_atomically([Parameter(SAVED_KEYS, value="")])
        config, values = file.load(), node.config.values
        kept = {name: values[name] for name in _keys(asked_for, values)}
        changed = [name for name, value in values.items() if value != config.values[name]]
        if changed and not asked_for:
            raise ConfigError([_unnamed(changed)], str(file.path))
        after = {**config.values, **kept}
        if problems := list(operators_problems(config.values, after)):
            raise ConfigError(problems, str(file.path))
        file.save(replace(config, values=after))
        return True, f"written to {file.path}"

    node.create_service(Trigger, "~/save_config", trigger(save))


def _keys(asked_for: list[str], values: Values) -> list[str]:
    """Returns the keys; a camera's `mode` stands for three."""
    modes = {mode_name(it): [f"{it.id}.{key}" for key in MODE_KEYS] for it in cameras()}
    known = {**{name: [name] for name in values}, **modes}
    for name in asked_for:
        if name not in known:
            shown = name[:MAX_SHOWN]
            message = f"expected keys with spaces between, found {shown}"
            for close in get_close_matches(shown, known, 1):
                message += f"; did you mean {close}?"
            raise ConfigError([Problem(0, SAVED_KEYS, shown, message)], "parameter")
    return [key for name in asked_for for key in known[name]]


def _unnamed(changed: list[str]) -> Problem:
    names = ", ".join(changed[:_MAX_LISTED])
    if len(changed) > _MAX_LISTED:
        names += f" and {len(changed) - _MAX_LISTED} more"
    message = (
        f"nothing is written, since it names no keys; not as in the file are {names}: name those to"
        " keep, as in `ml2-receiver call save_config KEY KEY`"
    )
    return Problem(0, SAVED_KEYS, "", message)
