"""Reads and sets parameters of a running receiver, and calls its services."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import rclpy
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from std_srvs.srv import Trigger

from ml2_receiver.errors import RosError
from ml2_receiver.ros.spinning import spin_until
from ml2_receiver.wire.json_body import Scalar


class ReceiverClient:
    """One receiver; close() ends it.

    Args:
        context: that of a node which has heard of the receiver.
        receiver: as in its --name, or empty.
        timeout_s: for each answer.
        services: are looked for at once, because ROS takes up to seconds to find one.
    """

    def __init__(
        self, context: Context, receiver: str, timeout_s: float, services: Iterable[str] = ()
    ) -> None:
        self._name = f"{'/' if receiver else ''}{receiver}/ml2_receiver"
        self._timeout_s = timeout_s
        self._node = rclpy.create_node("ml2_client", context=context)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)
        # A client lives as long as its node.
        self._parameter_client: AsyncParameterClient | None = None
        self._services = {it: self._service(it) for it in services}

    def close(self) -> None:
        self._executor.shutdown()
        self._node.destroy_node()

    def set(self, values: Mapping[str, Scalar]) -> tuple[bool, str]:
        """Sets all of these parameters, or none; what the receiver says of it.

        Raises:
            RosError: it does not answer.
        """
        client = self._parameters()
        parameters = [Parameter(name, value=value) for name, value in values.items()]
        result = self._answer(client.set_parameters_atomically(parameters)).result
        return result.successful, result.reason

    def get(self, names: Sequence[str]) -> dict[str, Scalar]:
        """Returns the values of these parameters; empty if the receiver has not all of them.

        Raises:
            RosError: it does not answer.
        """
        client = self._parameters()
        values = self._answer(client.get_parameters(list(names))).values
        return dict(zip(names, map(parameter_value_to_python, values), strict=False))

    def call(self, service: str) -> tuple[bool, str]:
        """Calls a service of the type std_srvs/Trigger; what the receiver says of it.

        Raises:
            RosError: it does not answer.
        """
        if service not in self._services:
            self._services[service] = self._service(service)
        client = self._services[service]
        if not client.wait_for_service(self._timeout_s):
            raise self._silent(service)
        answer = self._answer(client.call_async(Trigger.Request()))
        return answer.success, answer.message

    def _service(self, name: str) -> Client:
        return self._node.create_client(Trigger, f"{self._name}/{name}")

    def _parameters(self) -> AsyncParameterClient:
        if self._parameter_client is None:
            self._parameter_client = AsyncParameterClient(self._node, self._name)
        client = self._parameter_client
        if not client.wait_for_services(self._timeout_s):
            raise self._silent("parameter services")
        return client

    def _answer(self, future: Any) -> Any:
        if not spin_until(self._executor, future.done, self._timeout_s):
            raise RosError(f"{self._name} has not answered within {self._timeout_s:g} s")
        return future.result()

    def _silent(self, what: str) -> RosError:
        return RosError(f"{self._name} offers no {what} within {self._timeout_s:g} s")
