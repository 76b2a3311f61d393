"""The node's services."""

from collections.abc import Callable
from typing import Any

from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from ..configuration.config_file import ConfigFile
from ..configuration.table import load_table
from ..errors import ConfigError
from ..topics.control import Control
from .parameters import ParameterNode

# Whether it was done, and what there is to say of it.
type Outcome = tuple[bool, str]


def add_services(node: ParameterNode, control: Control, file: ConfigFile) -> None:
    """~/start, ~/stop, ~/save_config, ~/reload, and ~/enable_<section> for each that has `enabled`.

    They answer with what ROS's parameter services would, and log nothing themselves.
    """

    def start() -> Outcome:
        control.begin()
        return True, "streams run, or will when a headset is configured"

    def stop() -> Outcome:
        control.pause()
        return True, "streams are stopped until ~/start"

    def save() -> Outcome:
        try:
            file.save(node.config)
        except ConfigError as error:
            return False, str(error)
        return True, f"written to {file.path}"

    def reload() -> Outcome:
        try:
            result = node.load(file.load())
        except ConfigError as error:
            return False, str(error)
        return result.successful, result.reason

    for name, act in {
        "start": start,
        "stop": stop,
        "save_config": save,
        "reload": reload,
    }.items():
        node.create_service(Trigger, f"~/{name}", _trigger(act))
    for section in load_table().sections.values():
        if "enabled" in section.keys:
            node.create_service(SetBool, f"~/enable_{section.id}", _enable(node, section.id))


def _trigger(act: Callable[[], Outcome]) -> Callable[[Any, Any], Any]:
    def respond(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = act()
        return response

    return respond


def _enable(node: ParameterNode, section: str) -> Callable[[Any, Any], Any]:
    def respond(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        enabled = Parameter(f"{section}.enabled", Parameter.Type.BOOL, request.data)
        result = node.set_parameters_atomically([enabled])
        response.success, response.message = result.successful, result.reason
        return response

    return respond
