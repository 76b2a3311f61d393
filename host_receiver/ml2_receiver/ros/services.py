"""The node's services."""

from collections.abc import Callable
from typing import Any

from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from ..configuration.config_file import ConfigFile
from ..errors import ReceiverError
from ..table.reader import load_table
from ..topics.control import Control
from .parameters import ParameterNode

# Whether it was done, and what there is to say of it.
type Outcome = tuple[bool, str]


def add_services(node: ParameterNode, control: Control, file: ConfigFile) -> None:
    """~/start, ~/stop, ~/test_link, ~/save_config, ~/reload, ~/enable_<section> where it can be.

    They answer with what ROS's parameter services would, and log nothing themselves.
    """

    def start() -> Outcome:
        control.begin()
        return True, "streams run, or will when a headset is configured"

    def stop() -> Outcome:
        control.pause()
        return True, "streams are stopped until ~/start"

    def test_link() -> Outcome:
        control.test_link()
        return True, "filler is asked for; /diagnostics has the rate, row link, in a few seconds"

    def save() -> Outcome:
        file.save(node.config)
        return True, f"written to {file.path}"

    def reload() -> Outcome:
        result = node.load(file.load())
        return result.successful, result.reason

    for name, act in {
        "start": start,
        "stop": stop,
        "test_link": test_link,
        "save_config": save,
        "reload": reload,
    }.items():
        node.create_service(Trigger, f"~/{name}", trigger(act))
    for section in load_table().sections.values():
        if "enabled" in section.keys:
            node.create_service(SetBool, f"~/enable_{section.id}", _enable(node, section.id))


def trigger(act: Callable[[], Outcome]) -> Callable[[Any, Any], Any]:
    def respond(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            response.success, response.message = act()
        except ReceiverError as error:
            response.success, response.message = False, error.in_one_line()
        return response

    return respond


def _enable(node: ParameterNode, section: str) -> Callable[[Any, Any], Any]:
    def respond(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        enabled = Parameter(f"{section}.enabled", Parameter.Type.BOOL, request.data)
        result = node.set_parameters_atomically([enabled])
        response.success, response.message = result.successful, result.reason
        return response

    return respond
