"""Tools beside a receiver, when its headset and another node publish what nobody foresaw."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from itertools import cycle

import pytest

import bag_scene
from mock_device import MockDevice
from repeated import repeated
from viewing_browser import Browser, View
from waiting import await_true

pytest.importorskip("rclpy", reason="rclpy is not installed")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from configurations import only
from ml2_receiver.errors import RosError
from ml2_receiver.ros.context import tool_node
from ml2_tools.live.diagnostics_node import DiagnosticsNode
from ml2_tools.monitoring.latency_node import LatencyNode
from test_viewing_hostile import HOSTILE_ROWS, PLAIN
from waiting import LIMIT_S

pytestmark = pytest.mark.usefixtures("ros_of_children")
CONFIG = only("world_left: {enabled: true}, battery: {enabled: true}")
TOPIC = "world_left/image_raw"
HOSTILE = "hostile"


@contextmanager
def publishing(*messages: list[DiagnosticStatus]) -> Iterator[None]:
    """Publishes them again and again: those of the receiver itself replace them."""
    with tool_node("pretender") as node:
        publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 100)
        following = cycle(DiagnosticArray(status=rows) for rows in messages)
        with repeated(lambda: publisher.publish(next(following)), 0.05):
            yield


def pretender() -> AbstractContextManager[None]:
    """Publishes, in the receiver's name, rows that no receiver has."""
    every = (*HOSTILE_ROWS.values(), {HOSTILE: {"is": "\x1b]52;c;aGk=\x07"}})
    return publishing(*([status(*it) for it in rows.items()] for rows in every))


def status(name: str, values: dict[str, str]) -> DiagnosticStatus:
    pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
    return DiagnosticStatus(name=f"ml2_receiver: {name}", level=bytes([255]), values=pairs)


def test_a_page_goes_on_whatever_headset_and_other_nodes_publish(device: MockDevice) -> None:
    with View() as view, Browser(view.url, view.token) as browser:
        browser.say(show=["world_left", "scene", "cloud"])
        # Without a CDR head it would break the protocol.
        hostile = [it for it in PLAIN.values() if it]
        payloads = cycle(it for one in hostile for it in (one, bag_scene.image(1)))
        with repeated(lambda: device.publish(TOPIC, next(payloads)), 0.05):
            assert browser.picture().stream == "world_left"
            with pretender():
                while HOSTILE not in str(browser.text("state")["warnings"]):
                    pass
            while "world_left" not in [it["id"] for it in browser.text("state")["streams"]]:
                pass
            assert browser.picture().stream == "world_left"


@pytest.mark.usefixtures("device")
def test_nodes_of_tools_go_on_whatever_other_nodes_publish() -> None:
    watch, latency = DiagnosticsNode(), LatencyNode("", 1)
    try:
        await_true(lambda: "/magic_leap2/battery" in latency.breakdowns())
        with pretender():
            watch.rows("", LIMIT_S, lambda rows: HOSTILE in rows)
        rows = watch.rows("", LIMIT_S, lambda rows: "headset" in rows.get("session", {}))
        assert rows["session"]["headset"] == "device name"
        assert latency.session_state == "connected"
        assert "/magic_leap2/battery" in latency.breakdowns()
    finally:
        latency.close()
        watch.close()


@pytest.fixture
def watch() -> Iterator[DiagnosticsNode]:
    watch = DiagnosticsNode()
    yield watch
    watch.close()


def test_of_very_many_receivers_only_the_newest_are_remembered(watch: DiagnosticsNode) -> None:
    names = [f"r{number}/ml2_receiver: session" for number in range(200)]
    with publishing([DiagnosticStatus(name=it, level=b"\0") for it in names]):
        watch.rows("r199", LIMIT_S)
    assert "session" in watch.rows("r150", 0)
    with pytest.raises(RosError, match="no such receiver"):
        watch.rows("r100", 0)


@pytest.mark.parametrize("name", ["a b", "/x\x1b[2J", f"/{'x' * 240}", "/x[/y]"])
def test_a_node_with_an_impossible_name_is_no_receiver(watch: DiagnosticsNode, name: str) -> None:
    with (
        publishing([status("session", {"node": name})]),
        pytest.raises(RosError, match="expected the name of a node"),
    ):
        watch.node_name("", LIMIT_S)
