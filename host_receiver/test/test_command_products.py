"""`ml2-receiver products` in a ROS graph."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import String

from ros_processes import Child, environment
from waiting import LIMIT_S

PREFIX = "/products_test"
INPUTS = ("depth/image_raw", "depth/camera_info")


class Graph:
    """A node that sees what the command does."""

    def __init__(self) -> None:
        self.context = Context()
        rclpy.init(context=self.context, domain_id=int(environment()["ROS_DOMAIN_ID"]))
        self.node: Node = rclpy.create_node("products_test", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.statuses: dict[str, dict[str, str]] = {}
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._diagnosed, 10)

    def _diagnosed(self, array: DiagnosticArray) -> None:
        for status in array.status:
            name = status.name.removeprefix("ml2_products: ")
            self.statuses[name] = {pair.key: pair.value for pair in status.values}

    def await_that(self, is_true: Callable[[], Any]) -> None:
        deadline_s = time.monotonic() + LIMIT_S
        while not is_true():
            assert time.monotonic() < deadline_s
            self.executor.spin_once(timeout_sec=0.1)

    def subscribers(self, topic: str) -> int:
        return int(self.node.count_subscribers(f"{PREFIX}/{topic}"))

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Iterator[Graph]:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    graph = Graph()
    yield graph
    graph.close()


@pytest.fixture
def products() -> Iterator[Child]:
    with Child("-m", "ml2_receiver", "products", "--prefix", PREFIX) as child:
        assert child.line() == f"ready to make products of {PREFIX}"
        yield child


def test_it_subscribes_only_while_somebody_subscribes_to_it(graph: Graph, products: Child) -> None:
    graph.await_that(lambda: graph.node.count_publishers(f"{PREFIX}/depth/points"))
    graph.await_that(lambda: "losses" in graph.statuses)
    assert [graph.subscribers(topic) for topic in INPUTS] == [0, 0]
    assert not graph.node.count_subscribers("/tf")

    wanted = graph.node.create_subscription(
        PointCloud2, f"{PREFIX}/depth/points", lambda _: None, 5
    )
    graph.await_that(lambda: [graph.subscribers(topic) for topic in INPUTS] == [1, 1])
    assert not graph.subscribers("color/image_raw/compressed"), "nobody publishes it"

    graph.node.destroy_subscription(wanted)
    graph.await_that(lambda: [graph.subscribers(topic) for topic in INPUTS] == [0, 0])


def test_what_it_cannot_use_is_counted_in_diagnostics(graph: Graph, products: Child) -> None:
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    configs = graph.node.create_publisher(String, f"{PREFIX}/config", latched)
    images = graph.node.create_publisher(Image, f"{PREFIX}/depth/image_raw", 5)
    infos = graph.node.create_publisher(CameraInfo, f"{PREFIX}/depth/camera_info", 5)
    graph.node.create_subscription(PointCloud2, f"{PREFIX}/depth/points", lambda _: None, 5)
    configs.publish(String(data='{"streams": {}}'))

    def is_counted_when_sent() -> bool:
        images.publish(Image(width=4, height=4, encoding="32FC1", step=16, data=b"short"))
        infos.publish(CameraInfo())
        losses = graph.statuses.get("losses", {})
        return any(key.startswith("depth/points: expected") for key in losses)

    graph.await_that(is_counted_when_sent)
    assert products.end() == 0


def test_without_opencv_it_says_what_to_install() -> None:
    script = "import sys; sys.modules['cv2'] = None; from ml2_receiver.cli import main; "
    script += "sys.exit(main(['products']))"
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=environment(),
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert done.returncode == 2
    assert "pip install './host_receiver[products]'" in done.stderr
    assert "Traceback" not in done.stderr
