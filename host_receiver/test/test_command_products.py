"""`ml2-receiver products` in a ROS graph."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2
from std_msgs.msg import Header, String

from compressed_images import FORMAT, compressed_depth
from ml2_receiver.ros.context import end_node
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
        end_node(self.node)


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


class Compressing:
    """A headset that compresses depth, by what the graph's node publishes."""

    def __init__(self, graph: Graph) -> None:
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node, depth = graph.node, f"{PREFIX}/depth"
        self._configs = node.create_publisher(String, f"{PREFIX}/config", latched)
        self.images = node.create_publisher(CompressedImage, f"{depth}/{TRANSPORT}", 5)
        self._infos = node.create_publisher(CameraInfo, f"{depth}/camera_info", 5)
        self._configs.publish(String(data='{"streams": {}}'))
        self._stamp_s = 0

    def capture(self) -> None:
        self._stamp_s += 1
        header = Header(frame_id="depth_optical_frame", stamp=Time(sec=self._stamp_s))
        data = compressed_depth(np.full((3, 4), 1500, np.uint16))
        self.images.publish(CompressedImage(header=header, format=FORMAT, data=data))
        lens = {"k": [4.0, 0, 1.5, 0, 4, 1, 0, 0, 1], "d": [0.0] * 5, "r": np.eye(3).ravel()}
        info = CameraInfo(header=header, width=4, height=3, distortion_model="plumb_bob", **lens)
        info.p = [4.0, 0, 1.5, 0, 0, 4, 1, 0, 0, 0, 1, 0]
        self._infos.publish(info)


TRANSPORT = "image_raw/compressedDepth"


def received(graph: Graph, headset: Compressing, type: Any, topic: str) -> Any:
    """Returns the first message on a topic while the headset captures."""
    messages: list[Any] = []
    subscription = graph.node.create_subscription(type, f"{PREFIX}/{topic}", messages.append, 5)

    def has_arrived() -> bool:
        headset.capture()
        return bool(messages)

    graph.await_that(has_arrived)
    graph.node.destroy_subscription(subscription)
    return messages[0]


def test_depth_that_the_headset_compressed_becomes_points_and_raw(
    graph: Graph, products: Child
) -> None:
    headset = Compressing(graph)
    graph.await_that(lambda: graph.node.count_publishers(f"{PREFIX}/depth/image_raw") == 1)
    assert graph.subscribers(f"depth/{TRANSPORT}") == 0, "nobody wants a product of it"

    raw = received(graph, headset, Image, "depth/image_raw")
    assert (raw.encoding, raw.width, raw.height) == ("32FC1", 4, 3)
    assert np.frombuffer(raw.data, np.float32) == pytest.approx(1.5)
    graph.await_that(lambda: graph.subscribers(f"depth/{TRANSPORT}") == 0)

    cloud = received(graph, headset, PointCloud2, "depth/points")
    points = np.frombuffer(cloud.data, np.float32).reshape(3, 4, 3)
    assert points[..., 2] == pytest.approx(1.5)


def test_a_raw_image_never_has_two_publishers(graph: Graph, products: Child) -> None:
    """The headset's format changes twice."""
    topic = f"{PREFIX}/depth/image_raw"
    counts: list[int] = []

    def has_said_its_first_status() -> bool:
        counts.append(graph.node.count_publishers(topic))
        return "losses" in graph.statuses

    graph.await_that(has_said_its_first_status)
    assert set(counts) == {0}, "nobody publishes the compressed image"

    for _ in range(2):
        headset = Compressing(graph)
        graph.await_that(lambda: graph.node.count_publishers(topic) == 1)
        graph.node.destroy_publisher(headset.images)
        graph.await_that(lambda: graph.node.count_publishers(topic) == 0)

    headset = Compressing(graph)
    graph.await_that(lambda: graph.node.count_publishers(topic) == 1)
    other = graph.node.create_publisher(Image, topic, 5)
    graph.await_that(lambda: graph.node.count_publishers(topic) == 1)
    graph.node.destroy_publisher(other)


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
