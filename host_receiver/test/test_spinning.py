"""Executors that spin for months, and the end of their nodes."""

import ctypes
import gc
import threading
from collections.abc import Callable, Iterator

import pytest

pytest.importorskip("rclpy", reason="rclpy is not installed")

from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Task

from configurations import only
from ml2_receiver.ros.context import (
    end_node,
    fastdds_library,
    fastdds_participant,
    start_node_named,
    tool_node,
)
from ml2_receiver.ros.spinning import spin_until, wake
from ml2_tools.live.receiver_client import ReceiverClient
from ros_processes import Receiver
from waiting import LIMIT_S

CONFIG = only("battery: {enabled: true}")
LISTENER = "_ZNK8eprosima7fastdds3dds17DomainParticipant12get_listenerEv"
# The number of objects of a Python program differs by so many from one moment to another.
NOISE = 60


@pytest.fixture
def node(ros_of_children: None) -> Iterator[Node]:
    with tool_node("test_spinning") as node:
        yield node


@pytest.fixture
def executor(node: Node) -> Iterator[SingleThreadedExecutor]:
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    yield executor
    executor.shutdown()


def grown(runs: Callable[[], object]) -> int:
    """Returns the number of objects that a call of `runs` adds; the first call does not count."""
    counts = []
    for _ in range(2):
        runs()
        gc.collect()
        counts.append(len(gc.get_objects()))
    return counts[1] - counts[0]


def test_messages_leave_nothing_behind(node: Node, executor: SingleThreadedExecutor) -> None:
    ticks = 0

    def tick() -> None:
        nonlocal ticks
        ticks += 1

    node.create_timer(0.001, tick)

    def run() -> None:
        end = ticks + 200
        assert spin_until(executor, lambda: ticks >= end)

    assert grown(run) < NOISE


def test_requests_leave_nothing_behind(node: Node, receiver: Receiver) -> None:
    client = ReceiverClient(node.context, "/ml2_receiver", 40.0)

    def ask() -> None:
        for _ in range(50):
            assert client.get(["battery.enabled"]) == {"battery.enabled": True}

    assert grown(ask) < NOISE
    assert sum(isinstance(it, Task) for it in gc.get_objects()) < NOISE
    client.close()


def test_a_timeout_ends_it(executor: SingleThreadedExecutor) -> None:
    assert spin_until(executor, lambda: False, 0.05) is False


def test_another_thread_ends_it_without_a_message(executor: SingleThreadedExecutor) -> None:
    is_over = threading.Event()
    spinner = threading.Thread(target=spin_until, args=[executor, is_over.is_set])
    spinner.start()
    is_over.set()
    wake(executor)
    spinner.join(LIMIT_S)
    assert not spinner.is_alive()


@pytest.mark.usefixtures("ros_of_children")
def test_a_node_that_ends_hears_no_more_of_others(monkeypatch: pytest.MonkeyPatch) -> None:
    node = start_node_named("ending")
    listener = getattr(fastdds_library(), LISTENER)
    listener.restype = ctypes.c_void_p
    of_node = ctypes.c_void_p(fastdds_participant(node))
    heard = [listener(of_node)]
    monkeypatch.setattr(node, "destroy_node", lambda: heard.append(listener(of_node)))
    end_node(node)
    Node.destroy_node(node)
    assert heard[0] is not None
    assert heard[1:] == [None]
