"""The node's services."""

from collections.abc import Callable
from typing import Any

from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from ..configuration.config_file import ConfigFile
from ..table.reader import load_table
from ..topics.control import ReceiverControl
from .outcome import Outcome, trigger
from .parameters import ParameterNode
from .save_service import add_save_service


def add_services(node: ParameterNode, control: ReceiverControl, file: ConfigFile) -> None:
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

    def reload() -> Outcome:
        result = node.load(file.load())
        return result.successful, result.reason

    for name, act in {
        "start": start,
        "stop": stop,
        "test_link": test_link,
        "reload": reload,
    }.items():
        node.create_service(Trigger, f"~/{name}", trigger(act))
    add_save_service(node, file)
    for section in load_table().sections.values():
        if "enabled" in section.keys:
            node.create_service(SetBool, f"~/enable_{section.id}", _enable(node, section.id))


def _enable(node: ParameterNode, section: str) -> Callable[[Any, Any], Any]:
    def respond(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        enabled = Parameter(f"{section}.enabled", Parameter.Type.BOOL, request.data)
        result = node.set_parameters_atomically([enabled])
        response.success, response.message = result.successful, result.reason
        return response

    return respond
