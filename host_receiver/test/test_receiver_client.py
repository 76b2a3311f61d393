"""Requests of tools to a receiver that hears of them late.

rmw_fastrtps drops a service's answer if it does not know the client within 0.1 s.
"""

import threading
from collections.abc import Iterator
from functools import partial
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="rclpy is not installed")

import rclpy
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.node import Node
from std_srvs.srv import Trigger

from ml2_receiver.errors import RosError
from ml2_receiver.ros.context import spin_until, start_node, tool_node
from ml2_tools.live.receiver_client import ReceiverClient
from waiting import LIMIT_S, await_true

NEVER = 1 << 30


class LateReceiver:
    """The services of a receiver. They drop answers until parameters were asked for often enough.

    Args:
        node: the node `ml2_receiver`.
        deaf_for: how many requests for parameters have no answer.
    """

    def __init__(self, node: Node, deaf_for: int) -> None:
        self.requests: list[str] = []
        self._deaf_for = deaf_for
        for type, name in [
            (GetParameters, "get_parameters"),
            (SetParametersAtomically, "set_parameters_atomically"),
            (Trigger, "start"),
        ]:
            self._add(node, type, name)

    def _add(self, node: Node, type: Any, name: str) -> None:
        def answer(_: Any, response: Any) -> Any:
            self.requests.append(name)
            return response

        service = node.create_service(type, f"~/{name}", answer)
        send = service.send_response

        def send_if_heard(response: Any, header: Any) -> None:
            if self.requests.count("get_parameters") > self._deaf_for:
                send(response, header)

        service.send_response = send_if_heard  # type: ignore[method-assign]


@pytest.fixture
def late(ros_of_children: None, deaf_for: int) -> Iterator[LateReceiver]:
    create = partial(rclpy.create_node, "ml2_receiver", start_parameter_services=False)
    node = start_node(lambda context: create(context=context))
    late = LateReceiver(node, deaf_for)
    stopping = threading.Event()
    spinner = threading.Thread(target=spin_until, args=[stopping, node])
    spinner.start()
    yield late
    stopping.set()
    spinner.join(LIMIT_S)


@pytest.mark.parametrize("deaf_for", [2])
def test_a_request_is_made_once_and_only_when_its_answer_will_arrive(late: LateReceiver) -> None:
    with tool_node("tool") as tool:
        client = ReceiverClient(tool.context, "/ml2_receiver", 40.0, ["start"])
        client.call("start")
        client.set({"imu.enabled": True})
        client.close()
    assert [it for it in late.requests if it != "get_parameters"] == [
        "start",
        "set_parameters_atomically",
    ]
    assert late.requests[:3] == ["get_parameters"] * 3


@pytest.mark.parametrize("deaf_for", [NEVER])
def test_a_receiver_that_never_answers_gets_no_request(late: LateReceiver) -> None:
    with tool_node("tool") as tool:
        await_true(lambda: tool.count_services("/ml2_receiver/get_parameters") > 0)
        client = ReceiverClient(tool.context, "/ml2_receiver", 0.5, ["start"])
        with pytest.raises(RosError, match="has not answered"):
            client.call("start")
        client.close()
    await_true(lambda: bool(late.requests))
    assert set(late.requests) == {"get_parameters"}
