"""A callback of the node that fails unexpectedly ends nothing else, and is reported."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from configurations import only
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.printable import MOST_CHARACTERS
from ml2_receiver.session.report import Report
from ml2_receiver.session.streams import Request
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.wire.messages import Link
from mock_device import MockDevice
from ros_processes import Client
from waiting import LIMIT_S

pytest.importorskip("rclpy", reason="rclpy is not installed")

from ml2_receiver.ros.node import RosNode
from ml2_receiver.ros.sink import RosSink
from ml2_tools.live.diagnostics_node import DiagnosticsNode

CONFIG = only("battery: {enabled: true}")
NO_TYPE = 99


class FailingControl:
    """A ReceiverControl whose first report fails, and whose begin() always does."""

    def __init__(self) -> None:
        self.reports = 0

    def report(self) -> Report | None:
        self.reports += 1
        if self.reports == 1:
            raise ZeroDivisionError("the first report")
        return None

    def paired(self) -> None:
        return None

    def begin(self) -> None:
        raise KeyError("begin")

    def pause(self) -> None:
        raise ValueError(f"\x1b]52;c;aGk=\x07{'x' * 60_000}")

    def request(self, request: Request, link: Link | None = None, *, is_lazy: bool = False) -> None:
        pass

    def test_link(self) -> None:
        pass

    def demand(self, output: str, streams: Mapping[str, bool]) -> None:
        pass


@pytest.fixture
def node(config: Path, ros_of_children: None) -> Iterator[RosNode]:
    file = ConfigFile(config)
    with (
        RosNode(file.load(), []) as node,
        RosSink(node, FailingControl(), file, lambda _: None, FanOut([])),
    ):
        yield node


def test_a_service_answers_that_it_failed_and_goes_on(node: RosNode) -> None:
    with Client() as client:
        for _ in range(2):
            succeeded, words = client.ask("trigger", "start")
            assert (succeeded, "KeyError: 'begin'" in words) == (False, True)
        assert client.ask("trigger", "save_config")[0]


def test_an_error_that_quotes_others_is_short_and_says_nothing_to_a_terminal(
    node: RosNode, capfd: pytest.CaptureFixture[str]
) -> None:
    with Client() as client:
        succeeded, words = client.ask("trigger", "stop")
    assert (succeeded, r"ValueError: \x1b]52;c;aGk=\x07xx" in words) == (False, True)
    assert len(words) <= MOST_CHARACTERS
    logged = capfd.readouterr().err
    assert r"ValueError: \x1b]52;c;aGk=\x07xx" in logged
    assert len(logged) < 60_000
    assert "\x07" not in logged


def test_diagnostics_go_on_and_have_what_failed(node: RosNode) -> None:
    watch = DiagnosticsNode()
    try:
        rows = watch.rows("", LIMIT_S, lambda rows: "callbacks" in rows)
    finally:
        watch.close()
    assert rows["callbacks"]["failures"] == "1"
    assert "ZeroDivisionError: the first report" in rows["callbacks"]["message"]


def test_a_parameter_of_an_unknown_type_is_refused(device: MockDevice, client: Client) -> None:
    ((succeeded, words),) = client.ask("set_of_type", "battery.enabled", NO_TYPE)
    assert (succeeded, str(NO_TYPE) in words) == (False, True)
    assert client.ask("get", "battery.enabled") == [True]
