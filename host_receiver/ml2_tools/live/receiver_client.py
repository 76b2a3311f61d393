"""Reads and sets parameters of a running receiver, and calls its services."""

import time
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import rclpy
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.task import Future
from std_srvs.srv import Trigger

from ml2_receiver.errors import RosError
from ml2_receiver.printable import printable
from ml2_receiver.ros.spinning import spin_until
from ml2_receiver.wire.json_body import Scalar

_ASK_AGAIN_S = 1.0
_OF_RECEIVERS = "/test_link"  # a service that other nodes hardly have


class ReceiverClient:
    """One receiver; close() ends it.

    A ROS service drops its answer if it has not found the client within 0.1 s of the request
    (check_for_subscription() of rmw_fastrtps). So each request follows one for parameters, which is
    repeated until it is answered. The client for parameters is the newest, and ROS announces the
    clients of a process in order of creation: a receiver that answers it has found the others, too.

    Args:
        context: that of a node which has heard of the receiver.
        receiver: the full name of its node, as DiagnosticsNode.node_name() returns it.
        timeout_s: for each answer.
        services: those that will be called.
    """

    def __init__(
        self, context: Context, receiver: str, timeout_s: float, services: Iterable[str] = ()
    ) -> None:
        self._name = receiver
        self._timeout_s = timeout_s
        self._node = rclpy.create_node("ml2_client", context=context)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)
        self._services = {it: self._client(Trigger, it) for it in services}
        self._set = self._client(SetParametersAtomically, "set_parameters_atomically")
        self._get = self._client(GetParameters, "get_parameters")

    @property
    def name(self) -> str:
        """The full name of the receiver's node."""
        return self._name

    def receivers(self) -> Mapping[str, int]:
        """Returns the full names of the receivers' nodes in ROS's graph, with how many have each.

        All that have the name of this one get later requests. Waits for an answer of one of them,
        as each request does, while ROS finds the others.

        Raises:
            RosError: it does not answer.
        """
        self._ask(GetParameters.Request())
        services = self._node.get_service_names_and_types()
        names = [it.removesuffix(_OF_RECEIVERS) for it, _ in services if it.endswith(_OF_RECEIVERS)]
        return {it: self._node.count_services(it + _OF_RECEIVERS) for it in names}

    def close(self) -> None:
        self._executor.shutdown()
        self._node.destroy_node()

    def set(self, values: Mapping[str, Scalar]) -> tuple[bool, str]:
        """Sets all of these parameters, or none; what the receiver says of it.

        Raises:
            RosError: it does not answer.
        """
        parameters = [Parameter(name, value=it).to_parameter_msg() for name, it in values.items()]
        request = SetParametersAtomically.Request(parameters=parameters)
        result = self._request(self._set, request).result
        return result.successful, printable(result.reason)

    def get(self, names: Sequence[str]) -> dict[str, Scalar]:
        """Returns the values of these parameters; empty if the receiver has not all of them.

        Raises:
            RosError: it does not answer.
        """
        values = self._ask(GetParameters.Request(names=list(names))).values
        return dict(zip(names, map(parameter_value_to_python, values), strict=False))

    def call(self, service: str, keys: Sequence[str] = ()) -> tuple[bool, str]:
        """Calls a service of the type std_srvs/Trigger; what the receiver says of it.

        Args:
            keys: those that save_config saves.

        Raises:
            RosError: it does not answer.
        """
        if keys:
            is_set, why_not = self.set({"save.keys": " ".join(keys)})
            if not is_set:
                return False, why_not
        answer = self._request(self._services[service], Trigger.Request())
        return answer.success, printable(answer.message)

    def _client(self, type: Any, service: str) -> Client:
        return self._node.create_client(type, f"{self._name}/{service}")

    def _request(self, client: Client, request: Any) -> Any:
        self._ask(GetParameters.Request())
        self._find(client)
        answer = client.call_async(request)
        if not spin_until(self._executor, answer.done, self._timeout_s):
            raise self._silent()
        return answer.result()

    def _ask(self, request: GetParameters.Request) -> GetParameters.Response:
        self._find(self._get)
        deadline_s = time.monotonic() + self._timeout_s
        asked: list[Future] = []
        answer: Future | None = None
        while answer is None and (left_s := deadline_s - time.monotonic()) > 0:
            asked.append(self._get.call_async(request))
            spin_until(
                self._executor, lambda: any(it.done() for it in asked), min(left_s, _ASK_AGAIN_S)
            )
            answer = next((it for it in asked if it.done()), None)
        for unanswered in asked:
            self._get.remove_pending_request(unanswered)
        if answer is None:
            raise self._silent()
        return answer.result()

    def _find(self, client: Client) -> None:
        if not client.wait_for_service(self._timeout_s):
            raise RosError(f"there is no {client.service_name} within {self._timeout_s:g} s")

    def _silent(self) -> RosError:
        return RosError(f"{self._name} has not answered within {self._timeout_s:g} s")
