"""An independent node that calls the receiver's parameter services and its others.

Each line of standard input is [function, arguments...]; each answer is a line of JSON.
"""

import json
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

import rclpy
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from sensor_msgs.msg import CameraInfo
from sensor_msgs.srv import SetCameraInfo
from std_srvs.srv import SetBool, Trigger

from ml2_receiver.ros.fastdds import apply_default_profile
from waiting import LIMIT_S

_RECEIVER = "/ml2_receiver"


def await_heard(node: Node, is_done: Callable[[Any, float], bool]) -> None:
    """Waits until the receiver knows all clients of a node: before, an answer may be lost.

    It hears of them in their order, so it knows all when it answers the newest.

    Args:
        is_done: waits for a future, for so many seconds at most.
    """
    newest = node.create_client(GetParameters, f"{_RECEIVER}/get_parameters")
    assert newest.wait_for_service(LIMIT_S)
    for _ in range(int(LIMIT_S)):
        answer = newest.call_async(GetParameters.Request())
        if is_done(answer, 1):
            break
    node.destroy_client(newest)
    assert answer.done()


class Client:
    def __init__(self, node: Node) -> None:
        self._node = node
        self._parameters = AsyncParameterClient(node, _RECEIVER)
        assert self._parameters.wait_for_services(LIMIT_S)
        await_heard(node, self._is_done)

    def set(self, values: dict[str, Any]) -> Any:
        """One parameter after the other, as `ros2 param set`."""
        answer = self._await(self._parameters.set_parameters(_parameters(values)))
        return [[result.successful, result.reason] for result in answer.results]

    def set_atomically(self, values: dict[str, Any]) -> Any:
        answer = self._await(self._parameters.set_parameters_atomically(_parameters(values)))
        return [answer.result.successful, answer.result.reason]

    def set_of_type(self, name: str, type: int) -> Any:
        """Sets a parameter of a type that need not be one of ROS's."""
        request = SetParameters.Request(
            parameters=[ParameterMessage(name=name, value=ParameterValue(type=type))]
        )
        answer = self._answer(SetParameters, f"{_RECEIVER}/set_parameters", request)
        return [[result.successful, result.reason] for result in answer.results]

    def get(self, *names: str) -> Any:
        answer = self._await(self._parameters.get_parameters(list(names)))
        return [parameter_value_to_python(value) for value in answer.values]

    def names(self) -> Any:
        return self._await(self._parameters.list_parameters([], 0)).result.names

    def describe(self, *names: str) -> Any:
        answer = self._await(self._parameters.describe_parameters(list(names)))
        return [
            {
                "type": found.type,
                "description": found.description,
                "constraints": found.additional_constraints,
                "read_only": found.read_only,
                "integers": [[r.from_value, r.to_value, r.step] for r in found.integer_range],
                "numbers": [r.from_value for r in found.floating_point_range],
            }
            for found in answer.descriptors
        ]

    def trigger(self, service: str) -> Any:
        return self._call(Trigger, service, Trigger.Request())

    def enable(self, section: str, is_enabled: bool) -> Any:
        return self._call(SetBool, f"enable_{section}", SetBool.Request(data=is_enabled))

    def calibrate(self, camera: str, info: dict[str, Any]) -> Any:
        """Calls set_camera_info with fields of CameraInfo, as camera_calibration does on COMMIT."""
        request = SetCameraInfo.Request(camera_info=CameraInfo(**info))
        answer = self._answer(SetCameraInfo, f"{camera}/set_camera_info", request)
        return [answer.success, answer.status_message]

    def _call(self, type: Any, name: str, request: Any) -> Any:
        answer = self._answer(type, f"{_RECEIVER}/{name}", request)
        return [answer.success, answer.message]

    def _answer(self, type: Any, name: str, request: Any) -> Any:
        client = self._node.create_client(type, name)
        assert client.wait_for_service(LIMIT_S)
        await_heard(self._node, self._is_done)
        return self._await(client.call_async(request))

    def _is_done(self, future: Any, timeout_s: float) -> bool:
        rclpy.spin_until_future_complete(self._node, future, timeout_sec=timeout_s)
        return bool(future.done())

    def _await(self, future: Any) -> Any:
        rclpy.spin_until_future_complete(self._node, future, timeout_sec=LIMIT_S)
        return future.result()


def _parameters(values: dict[str, Any]) -> list[Parameter]:
    return [Parameter(name, value=value) for name, value in values.items()]


def main() -> None:
    # A shell may have started the tests to ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # So that Fast DDS writes no log among the lines
    apply_default_profile(os.environ, sends_images=False)
    rclpy.init()
    client = Client(rclpy.create_node("client"))
    for line in sys.stdin:
        function, *arguments = json.loads(line)
        print(json.dumps(getattr(client, function)(*arguments)), flush=True)


if __name__ == "__main__":
    main()
